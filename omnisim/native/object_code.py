"""Kernels as an object file: functions of C that take the memory of a machine, and call libm and memcpy at most.

Numba has its own compiler ahead of time, pycc, which wraps every function for Python, takes no records and is about to
go. Here the kernels' own parts are linked as for a call from Python. In the place of that call stands a function of one
pointer: what a kernel is given, shapes and strides of arrays included, are constants in it, places in the memory.
"""

from typing import Any, NamedTuple

import llvmlite.binding as llvm
import numba
from llvmlite import ir
from numba.core import types
from numba.core.codegen import JITCodeLibrary
from numba.np.arrayobj import make_array, populate_array

from omnisim.base.compiler import absorbed, linked, reached
from omnisim.native.memory import Memory

NATIVE = "native"
POINTER, WORD = ir.IntType(8).as_pointer(), ir.IntType(64)
FAILED = -1  # what a function returns for an exception, which no kernel raises


class Entry(NamedTuple):
    """A kernel as a function of C by this name: int64_t name(unsigned char *memory)."""

    name: str
    kernel: Any
    arguments: tuple[Any, ...]


def object_code(entries: list[Entry], memory: Memory, start: str, cpu: str) -> bytes:
    """The object file of these functions, and of a constant called `start`, the memory of a machine that begins.

    cpu: "generic", any of this architecture, or "native", those like this one.
    """
    target = target_machine(cpu)
    results = [compiled(entry) for entry in entries]
    codegen = results[0].target_context.codegen()
    library = NativeLibrary(codegen, "omnisim")
    module = library.create_ir_module("omnisim")
    for entry, result in zip(entries, results, strict=True):
        define(module, entry, result, memory)
        library.add_linking_library(result.library)
    add_start(module, memory, start)
    library.add_ir_module(module)
    library.finalize()
    return target.emit_object(library.linked({*(entry.name for entry in entries), start}))


def target_machine(cpu: str) -> llvm.TargetMachine:
    """What writes code for a processor, to be placed anywhere."""
    features = ""
    if cpu == NATIVE:
        cpu, features = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    return target.create_target_machine(cpu=cpu, features=features, opt=3, reloc="pic", codemodel="default")


def compiled(entry: Entry) -> Any:
    """What Numba has of the kernel for these arguments."""
    signature = tuple(map(numba.typeof, entry.arguments))
    entry.kernel.compile(signature)
    return entry.kernel.overloads[signature]


class NativeLibrary(JITCodeLibrary):
    """Functions with all that they need, optimised as what Python calls is, and never loaded into this process."""

    def finalize(self) -> None:
        calls = absorbed(self, linked(self))
        self._optimize_final_module()
        for part in reached(calls):
            if not part.inlined:
                code = part.module().clone()
                code.get_function(part.symbol).linkage = "weak_odr"  # else one that none calls yet would be left out
                self._final_module.link_in(code)
        self._final_module.verify()
        self._finalized = True

    def linked(self, public: set[str]) -> llvm.ModuleRef:
        """The code, of which only what is public has a name that other object files can see; libraries show none."""
        module = self._final_module
        for symbol in (*module.functions, *module.global_variables):
            if symbol.name in public:
                symbol.visibility = "hidden"
            elif not symbol.is_declaration:
                symbol.linkage = "internal"
        return module


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


def add_start(module: ir.Module, memory: Memory, name: str) -> None:
    start = memory.start
    kind = ir.ArrayType(ir.IntType(8), len(start))
    constant = ir.GlobalVariable(module, kind, name)
    constant.initializer = kind(bytearray(start))
    constant.global_constant = True
