"""Files that a question takes besides cases, such as the structure of a design: forms of them."""

import tomllib
from collections.abc import Callable
from typing import Any, NamedTuple

from granulab.contact.files.casefile import CaseFile
from granulab.studio.folder import Folder
from granulab.studio.forms import Texts, case_form, document, texts_of, to_toml

_HEAD = "Made by granulab studio; `{command} {file}` answers it."


class OwnFile(NamedTuple):
    """A kind of file: the command that takes it, its schema, and the example that is shipped."""

    command: str
    file: CaseFile[Any]
    example: Callable[[], str]

    def form(self) -> dict[str, Any]:
        """Its sections and keys, and the texts of the example."""
        tables = tomllib.loads(self.example())
        del tables["schema"]
        return {"form": case_form(self.file.settings), "texts": texts_of(tables)}

    def texts(self, folder: Folder, name: str) -> Texts:
        """The texts of a file of this kind in the folder; InputError where it is none."""
        tables = self.file.read(folder.file(name))
        self.file.check(tables, name)
        return texts_of(tables)

    def save(self, folder: Folder, texts: Texts, replace: bool) -> dict[str, Any]:
        """Write the file of a form, where no other stands under its name or it may go.

        Raises InputError, the line that the command would say, for what cannot stand in it.
        """
        tables = document(self.file.settings, texts)
        file = f"{tables.setdefault('name', 'question')}.toml"
        folder.refuse_outside(tables, file)
        self.file.check(tables, file)
        head = _HEAD.format(command=self.command, file=file)
        written = folder.write(file, to_toml(tables, self.file.schema, head), replace)
        return {"file": file, "exists": not written}
