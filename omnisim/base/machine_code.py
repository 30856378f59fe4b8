"""Where the machine code of kernels lies: close to the numbers that it needs, so that it finds them by a short way.

Numba takes them to be anywhere in memory: an instruction of ten bytes has the address of every constant before the one
that reads it, and of every function before its call. Here what is loaded together lies together, and a distance of four
bytes is part of the instruction that reads. On an EPYC of the first generation, slow to decode, marches take 2 to 8 %
less time (medians in turn; the fastest of a bare wheel 17 %).
"""

import platform
import sys
from functools import cache

from numba.core import config as numba_config
from numba.core.caching import CompileResultCacheImpl
from numba.core.codegen import JITCPUCodegen


class CloseCodegen(JITCPUCodegen):
    """Numba's generator of machine code, with distances of four bytes."""

    def _init(self, module):
        theirs = numba_config.USE_LLVMLITE_MEMORY_MANAGER
        numba_config.USE_LLVMLITE_MEMORY_MANAGER = True  # which keeps all of an object in one piece
        try:
            super()._init(module)
        finally:
            numba_config.USE_LLVMLITE_MEMORY_MANAGER = theirs

    def _customize_tm_options(self, options):
        super()._customize_tm_options(options)
        options["reloc"], options["codemodel"] = "pic", "small"


@cache
def close_codegen():
    """The one generator of this process; None where Numba's own is to be taken."""
    tried = sys.platform == "linux" and platform.machine() == "x86_64"
    return CloseCodegen("omnisim") if tried else None


def codegen_of(context):
    """The generator of machine code for kernels; context: Numba's, of its target."""
    return close_codegen() or context.codegen()


class EntryResults(CompileResultCacheImpl):
    """How machine code that is kept on disk is loaded."""

    def rebuild(self, target_context, payload):
        return super().rebuild(Generating(target_context), payload)


class Generating:
    """Numba's context of its target, with the generator of kernels."""

    def __init__(self, context):
        self._context = context

    def __getattr__(self, name):
        return getattr(self._context, name)

    def codegen(self):
        return codegen_of(self._context)
