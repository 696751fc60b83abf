"""Tuples of arrays that kernels hand on by their place in memory, not array by array.

To numba an array is seven numbers and a tuple all of its arrays: a function that takes a world of a
hundred arrays has 700 arguments, and where it calls another it hands on 700, which takes longer to
compile than most functions. `handed(world)` puts the tuple on the stack, and a pointer stands for
it from there on. Fields are read as those of the tuple are. Only for functions that count no
references (jit.uncounted and its like), and not to be returned or kept: it lives as long as the
function that put it there.

For what is seldom called (searches, samples). In the passes over contacts it costs half as much
time again: of arrays that are read from memory LLVM does not know that they do not overlap.
"""

from typing import Any

from numba.core import cgutils, types
from numba.core.datamodel import models, register_default
from numba.core.imputils import lower_builtin, lower_getattr_generic
from numba.core.typing.templates import (
    AbstractTemplate,
    AttributeTemplate,
    infer_getattr,
    infer_global,
)


def handed(whole: Any) -> Any:
    """Return a named tuple in the form in which kernels hand it on; to Python it is the same."""
    return whole


class Handed(types.Type):
    """Type of such a tuple; `fields` and items are those of the tuple's own."""

    def __init__(self, whole: Any) -> None:
        self.dtype = whole  # what numba's model of pointers calls that which they point to
        super().__init__(name=f"Handed({whole})")

    @property
    def key(self) -> Any:
        """The tuple's own type: two classes of one name are two."""
        return self.dtype

    @property
    def fields(self) -> Any:
        """Names of the fields."""
        return self.dtype.fields

    def __getitem__(self, k: int) -> Any:  # type: ignore[override]
        """Type of field k."""
        return self.dtype[k]


register_default(Handed)(models.PointerModel)


@infer_global(handed)
class _Handing(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        (whole,) = args
        return (whole if isinstance(whole, Handed) else Handed(whole))(whole)


@lower_builtin(handed, types.NamedTuple)
def _put(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return cgutils.alloca_once_value(
        builder, context.data_model_manager[signature.args[0]].as_data(builder, arguments[0])
    )


@lower_builtin(handed, Handed)
def _leave(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return arguments[0]


@infer_getattr
class _Fields(AttributeTemplate):
    key = Handed

    def generic_resolve(self, whole: Handed, name: str) -> Any:  # type: ignore[override]
        return whole[whole.fields.index(name)] if name in whole.fields else None


@lower_getattr_generic(Handed)
def _field(context: Any, builder: Any, whole: Handed, place: Any, name: str) -> Any:
    k = whole.fields.index(name)
    model = context.data_model_manager[whole[k]]
    return model.load_from_data_pointer(builder, cgutils.gep_inbounds(builder, place, 0, k))
