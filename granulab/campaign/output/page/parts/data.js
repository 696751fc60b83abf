// Numbers of a page, unpacked: what granulab/campaign/output/page/packing.py packed.

/** What the page is about: the JSON that stands in it. */
export function readData() {
  return JSON.parse(document.getElementById("data").textContent);
}

/** All arrays of the page by name. Rejects where the browser is too old to inflate them. */
export async function unpack(heads) {
  if (typeof DecompressionStream === "undefined") {
    throw new Error("This browser cannot inflate the page's data: it needs one of 2023 or later.");
  }
  const deflated = fromBase64(document.getElementById("arrays").textContent);
  const inflating = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(inflating).arrayBuffer());
  const arrays = {};
  let start = 0;
  for (const head of heads) {
    const size = head.shape.reduce((product, n) => product * n, 1);
    const end = start + size * head.bytes;
    arrays[head.name] = new Quantised(head, integersOf(bytes.subarray(start, end), head, size));
    start = end;
  }
  return arrays;
}

/** An array of integers and the values that they stand for; rows are frames, samples, contacts. */
export class Quantised {
  constructor(head, integers) {
    Object.assign(this, head, { integers });
    this.rows = head.shape[0];
    this.width = this.rows ? integers.length / this.rows : 0;
  }

  value(integer) {
    if (!this.logarithmic) return this.low + this.step * integer;
    return integer ? this.low * Math.exp(this.step * (integer - 1)) : 0;
  }

  at(row, column = 0) {
    return this.value(this.integers[row * this.width + column]);
  }

  row(row) {
    return this.integers.subarray(row * this.width, (row + 1) * this.width);
  }
}

function fromBase64(text) {
  const letters = atob(text.trim());
  const bytes = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) bytes[k] = letters.charCodeAt(k);
  return bytes;
}

/** Column by column: signs unfolded, differences summed modulo 2^16 as often as they were taken. */
function integersOf(bytes, { shape, order }, size) {
  const integers = new Uint16Array(size);
  const rows = shape[0], width = rows ? size / rows : 0;
  const wide = bytes.length > size;
  for (let column = 0, k = 0; column < width; column++) {
    let value = 0, first = 0;
    for (let row = 0; row < rows; row++, k++) {
      const folded = wide ? bytes[k] | (bytes[size + k] << 8) : bytes[k];
      const difference = (folded >> 1) ^ -(folded & 1);
      if (order === 0) value = difference;
      else if (order === 1) value += difference;
      else value += first += difference;
      integers[row * width + column] = value;
    }
  }
  return integers;
}
