"""Machine code of kernels: each in one piece of memory with the numbers that it needs, found by a short way.

Numba takes them to be anywhere in memory: an instruction of ten bytes has the address of every constant before the one
that reads it, and of every function before its call. Here a distance of four bytes is part of the instruction that
reads, and LLVM's linker JITLink puts all of a kernel in one piece, with a bridge to each function that is far away. On
an EPYC of the first generation, slow to decode, marches of three machines take 0.88 to 0.99 of the time, in turn, and
one of many machines side by side 1.05.
"""

import ctypes
import platform
import sys
from functools import cache
from itertools import count

import llvmlite.binding as llvm
from numba.core import config
from numba.core.codegen import JITCodeLibrary

IN_ONE_PIECE = sys.platform == "linux" and platform.machine() == "x86_64"  # else, untried, Numba places it
NUMBER = count()


class MachineCode(JITCodeLibrary):
    """A library that is translated to an object file, which can be kept and loaded again.

    own: names of what it has before others are linked with it. object_file: bytes. exported, imported: names of what
    is left of its own, and of what is not in it.
    """

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        imported = [symbol.name for symbol in symbols(self._final_module) if symbol.is_declaration]
        exported = [name for name in seen(self._final_module) if name in self.own]
        self.load(target_machine(self._codegen).emit_object(self._final_module), exported, imported)

    def load(self, object_file, exported, imported):
        self.object_file, self.exported, self.imported = object_file, exported, imported
        self._addresses = in_one_piece(self) if IN_ONE_PIECE else by_numba(self)
        self._disable_inspection = True  # Numba would show what it makes of a module, not this
        self._finalized = True

    def get_pointer_to_function(self, name):
        self._ensure_finalized()
        return self._addresses[name]

    @property
    def codegen(self):
        return self  # whom Numba asks to set environments

    def set_env(self, name, environment):
        """Let this name in the code stand for a Python object, what Numba calls an environment."""
        ctypes.c_void_p.from_address(self._addresses[name]).value = id(environment)


def symbols(module):
    """What a module defines or declares."""
    return [*module.functions, *module.global_variables]


def seen(module):
    """Names of what a module defines, for others to see."""
    hidden = llvm.Linkage.internal, llvm.Linkage.private
    return [s.name for s in symbols(module) if not s.is_declaration and s.linkage not in hidden]


@cache
def target_machine(codegen):
    """What translates to machine code, for this processor as Numba's own does."""
    if not IN_ONE_PIECE:
        return codegen._tm
    options = {"opt": config.OPT}
    codegen._customize_tm_options(options)
    options |= {"reloc": "pic", "codemodel": "small"}
    return llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine(**options)


@cache
def linker():
    return llvm.create_lljit_compiler(use_jit_link=True)


def in_one_piece(code):
    """Load it: addresses of what is exported, by name, for as long as they are kept."""
    builder = llvm.JITLibraryBuilder().add_object_img(code.object_file).add_current_process()
    for name in code.imported:
        address = llvm.address_of_symbol(name)  # also of what Numba told LLVM alone
        if address is not None:
            builder.import_symbol(name, address)
    for name in code.exported:
        builder.export_symbol(name)
    return builder.link(linker(), f"{code.name}.{next(NUMBER)}")


def by_numba(code):
    """The same, for good."""
    engine = code._codegen._engine._ee
    engine.add_object_file(llvm.ObjectFileRef.from_data(code.object_file))
    engine.finalize_object()
    return {name: engine.get_global_value_address(name) for name in code.exported}
