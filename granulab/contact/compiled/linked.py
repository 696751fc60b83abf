"""Functions that only kernels call: compiled as far as others take them in, and no further.

numba makes machine code of each function that it compiles, with all that it calls in it. Of one
that is never called from Python nobody runs it: it stands in the kernels that call it. A kernel of
a hundred such functions, one in the other, compiles in two thirds of the time without.
"""

from typing import Any

from llvmlite import binding
from numba.core.caching import CompileResultCacheImpl
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, CompileResult, DefaultPassBuilder


class _WithoutRun:
    """A code generator to which nothing is told of what running needs."""

    def __init__(self, codegen: Any) -> None:
        self._codegen = codegen

    def set_env(self, *_: Any) -> None:
        """Leave out the environment, of Python's objects: none of these functions has any."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self._codegen, name)


class LinkedLibrary(JITCodeLibrary):
    """The code of one function, for others to take in."""

    @classmethod
    def kept(cls, codegen: Any, name: str, code: bytes) -> "LinkedLibrary":
        """Make that of a function whose code was kept."""
        library = cls(codegen, name)
        library._final_module = binding.parse_bitcode(code)
        library._finalize_final_module()
        return library

    @property
    def codegen(self) -> Any:
        """The code generator, for what runs code."""
        return _WithoutRun(self._codegen)

    def _optimize_functions(self, ll_module: Any) -> None:
        """Leave out what is only declared: setting its passes up takes as long as code's."""
        ll_module.data_layout = self._codegen._data_layout
        for function in ll_module.functions:
            if not function.is_declaration:
                passes, builder = self._codegen._function_pass_manager()
                passes.run(function, builder)

    def _optimize_final_module(self) -> None:
        """Leave it to who takes the code in."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0: there is no machine code."""
        self._ensure_finalized()
        return 0

    def serialize_using_object_code(self) -> tuple[str, bytes]:
        """Return the arguments of `kept`."""
        self._ensure_finalized()
        return self.name, self._final_module.as_bitcode()


class InnerCompiler(CompilerBase):
    """numba's compiler, of a function that only kernels call."""

    def define_pipelines(self) -> list[Any]:
        """As for any function."""
        state = self.state
        if state.library is None:
            state.library = LinkedLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        return [DefaultPassBuilder.define_nopython_pipeline(state)]


class LinkedCache(CompileResultCacheImpl):
    """Form in which such a function comes back from the disk."""

    def rebuild(self, target_context: Any, payload: Any) -> CompileResult:
        """See CompileResult._rebuild."""
        (name, code), described, environment, signature, *_, annotation, again, others = payload
        library = LinkedLibrary.kept(target_context.codegen(), name, code)
        fields = dict.fromkeys(CompileResult._fields) | {
            "target_context": target_context,
            "typing_context": target_context.typing_context,
            "library": library,
            "environment": environment,
            "entry_point": target_context.get_executable(library, described, environment),
            "fndesc": described,
            "type_annotation": annotation,
            "signature": signature,
            "objectmode": False,
            "lifted": (),
            "reload_init": again,
            "referenced_envs": others,
        }
        return CompileResult(**fields)
