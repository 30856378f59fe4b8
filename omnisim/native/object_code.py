"""Kernels as an object file: functions of C that take the memory of a machine, and call libm and memcpy at most.

Numba has its own compiler ahead of time, pycc, which wraps every function for Python, takes no records and is about to
go. Here the kernels' own parts are linked as for a call from Python. In the place of that call stands a function of one
pointer: what a kernel is given, shapes and strides of arrays included, are constants in it, places in the memory.
"""

import platform
from typing import Any, NamedTuple

import llvmlite.binding as llvm
import numba
from llvmlite import ir
from numba.core import types
from numba.core.codegen import JITCodeLibrary
from numba.np.arrayobj import make_array, populate_array

from omnisim.base.compiler import link_all
from omnisim.native.memory import Memory

POINTER, WORD = ir.IntType(8).as_pointer(), ir.IntType(64)
FAILED = -1  # what a function returns for an exception, which no kernel raises
LEVELS = {  # by architecture, what processors may have or not and Numba has code for where they do, the most last
    "x86_64": {
        "avx2": ("avx2", "fma"),
        "avx512": ("avx2", "fma", "avx512f", "avx512cd", "avx512bw", "avx512dq", "avx512vl"),
    }
}


class Entry(NamedTuple):
    """A kernel as a function of C by this name: int64_t name(unsigned char *memory)."""

    name: str
    kernel: Any
    arguments: tuple[Any, ...]


class Target(NamedTuple):
    """A kind of processor, as LLVM names it and its features; level: of LEVELS, what names of functions for it end
    with, and needed: the features that it has to be asked for first."""

    cpu: str
    features: str = ""
    level: str = ""
    needed: tuple[str, ...] = ()


def targets(cpu: str) -> list[Target]:
    """Kinds of processors to write code for; cpu: "generic", any of this architecture, with code of its own for each
    level, or "native", those like this one."""
    if cpu == "native":
        return [Target(llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten())]
    levels = LEVELS.get(platform.machine(), {})
    more = [
        Target("generic", ",".join(f"+{feature}" for feature in needed), f"_{level}", needed)
        for level, needed in levels.items()
    ]
    return [Target("generic"), *more]


def object_code(entries: list[Entry], memory: Memory, kinds: list[Target]) -> list[bytes]:
    """Object files of these functions, one for each kind of processor."""
    results = [compiled(entry) for entry in entries]
    codegen = results[0].target_context.codegen()
    library = NativeLibrary(codegen, "omnisim")
    module = library.create_ir_module("omnisim")
    for entry, result in zip(entries, results, strict=True):
        define(module, entry, result, memory)
        library.add_linking_library(result.library)
    library.add_ir_module(module)
    library.finalize()
    names = {entry.name for entry in entries}
    return [emitted(library.module, names, kind) for kind in kinds]


def constant(name: str, content: bytes) -> bytes:
    """The object file of a constant by this name: const unsigned char name[]."""
    module = ir.Module(name)
    kind = ir.ArrayType(ir.IntType(8), len(content))
    whole = ir.GlobalVariable(module, kind, name)
    whole.initializer, whole.global_constant = kind(bytearray(content)), True
    return emitted(llvm.parse_assembly(str(module)), {name}, Target("generic"))


def emitted(module: llvm.ModuleRef, public: set[str], kind: Target) -> bytes:
    """The object file of a module for a kind of processor, to be placed anywhere. Other object files see what is public
    alone, by its name with the level of the kind, and libraries show none of it."""
    own = module.clone()  # which is changed on the way
    for symbol in (*own.functions, *own.global_variables):
        if symbol.name in public:
            symbol.visibility = "hidden"
            symbol.name += kind.level
        elif not symbol.is_declaration:
            symbol.linkage = "internal"
    target = llvm.Target.from_triple(llvm.get_process_triple())
    machine = target.create_target_machine(kind.cpu, kind.features, opt=3, reloc="pic", codemodel="default")
    return machine.emit_object(own)


def compiled(entry: Entry) -> Any:
    """What Numba has of the kernel for these arguments."""
    signature, kernel = tuple(map(numba.typeof, entry.arguments)), entry.kernel.apart
    kernel.compile(signature)
    return kernel.overloads[signature]


class NativeLibrary(JITCodeLibrary):
    """Functions with all that they need, optimised as what Python calls is, and never loaded into this process."""

    def finalize(self) -> None:
        link_all(self)
        self._finalized = True

    @property
    def module(self) -> llvm.ModuleRef:
        return self._final_module


def define(module: ir.Module, entry: Entry, result: Any, memory: Memory) -> None:
    """The function of C that calls a kernel: what it returns, 0 of one that returns nothing, or FAILED."""
    context = result.target_context
    function = ir.Function(module, ir.FunctionType(WORD, [POINTER]), entry.name)
    builder = ir.IRBuilder(function.append_basic_block())
    given = Arguments(context, builder, function.args[0], memory)
    signature = result.signature
    values = [given.value(kind, value) for kind, value in zip(signature.args, entry.arguments, strict=True)]
    callee = context.declare_function(module, result.fndesc)
    call = context.call_conv.call_function
    status, returned = call(builder, callee, signature.return_type, signature.args, values)
    found = returned if isinstance(signature.return_type, types.Integer) else WORD(0)
    builder.ret(builder.select(status.is_ok, found, WORD(FAILED)))


class Arguments(NamedTuple):
    """Arguments of a kernel, as Numba hands them over, made of constants and of the address of a memory."""

    context: Any
    builder: ir.IRBuilder
    address: ir.Argument
    memory: Memory

    def value(self, kind: types.Type, value: Any) -> ir.Value:
        context, builder = self.context, self.builder
        if isinstance(kind, types.BaseTuple):
            parts = [self.value(own, part) for own, part in zip(kind.types, value, strict=True)]
            return context.make_tuple(builder, kind, parts)
        if isinstance(kind, types.Record):
            return builder.bitcast(self.place(value), context.get_value_type(kind))
        if isinstance(kind, types.Array):
            return self.array(kind, value)
        return context.get_constant_generic(builder, kind, value)

    def array(self, kind: types.Array, value: Any) -> ir.Value:
        own = make_array(kind)(self.context, self.builder)
        first = self.builder.bitcast(self.place(value), self.context.get_data_type(kind.dtype).as_pointer())
        shape, strides = map(self.words, (value.shape, value.strides))
        populate_array(own, first, shape, strides, itemsize=WORD(value.itemsize), meminfo=None)
        return own._getvalue()

    def words(self, numbers: tuple[int, ...]) -> list[ir.Constant]:
        return [WORD(number) for number in numbers]

    def place(self, array: Any) -> ir.Value:
        return self.builder.gep(self.address, [WORD(self.memory[array])])
