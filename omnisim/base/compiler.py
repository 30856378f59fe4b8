"""How kernels are compiled: what a scene does not have is left out, and every kernel is optimised once.

Numba would optimise and translate every function by itself, with all that it calls, and again within each of its
callers. Here a kernel is a part, and only what Python calls becomes machine code:

    inlined     its own code alone; wherever it is called it becomes part of what is optimised there
    outlined    optimised once, with the inlined ones that it calls; what else it calls stays a call
    entry       the same, and linked with all outlined kernels that it reaches, which are given what they use and no
                more: then it is translated, once
"""

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from operator import is_, is_not
from typing import NamedTuple

import llvmlite.binding as llvm
from numba import _dynfunc
from numba.core import ir, itanium_mangler, types
from numba.core.caching import CompileResultCacheImpl
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.ir_utils import get_definition, guard
from numba.core.typed_passes import NativeLowering
from numba.core.types.functions import BaseFunction
from numba.core.untyped_passes import RewriteSemanticConstants

from omnisim.base.machine_code import MachineCode, seen
from omnisim.base.records import zero_title


@register_pass(mutates_CFG=False, analysis_only=False)
class FoldAbsent(FunctionPass):
    """What a scene does not have is None in what its kernels are given, or a number that is 0 in all records of a type
    (`without`). So `run.newton is None` and `machine.rolling` are known from the types: they become constants, and
    Numba drops the branch that is never taken before it looks at what is in it."""

    _name = "fold_absent"

    def __init__(self):
        FunctionPass.__init__(self)

    def run_pass(self, state):
        folded = False
        for block in state.func_ir.blocks.values():
            for statement in block.body:
                value = getattr(statement, "value", None)
                known = known_from_types(state, value) if isinstance(value, ir.Expr) else None
                if known is not None:
                    definitions = state.func_ir._definitions[statement.target.name]
                    definitions[definitions.index(value)] = statement.value = ir.Const(known, statement.loc)
                    folded = True
        return folded


def known_from_types(state, value):
    """What an expression is for all arguments of these types: a number; None of most."""
    if value.op == "binop" and value.fn in (is_, is_not) and is_none(state.func_ir, value.rhs):
        kind = type_of(state, value.lhs)
        return None if kind is None else isinstance(kind, types.NoneType) == (value.fn is is_)
    if value.op == "getattr":
        whole = type_of(state, value.value)
        field = whole.fields.get(value.attr) if isinstance(whole, types.Record) else None
        if field is not None and field.title == zero_title(value.attr):
            return 0.0 if isinstance(field.type, types.Float) else 0
    return None


def is_none(func_ir, variable):
    """Whether a variable of Numba's intermediate representation is the constant None."""
    found = guard(get_definition, func_ir, variable)
    return isinstance(found, ir.Const | ir.Global | ir.FreeVar) and found.value is None


def type_of(state, variable):
    """Numba's type of a variable that is an argument, or a member of one; None of any other."""
    found = guard(get_definition, state.func_ir, variable)
    if isinstance(found, ir.Arg):
        return state.args[found.index]
    if isinstance(found, ir.Expr) and found.op == "getattr":
        whole = type_of(state, found.value)
        if isinstance(whole, types.BaseNamedTuple) and found.attr in whole.fields:
            return whole[whole.fields.index(found.attr)]
    return None


class Source(NamedTuple):
    """Where a compiled kernel comes from: its module, its name there, and the types of its arguments."""

    module: str
    name: str
    arguments: tuple

    def library(self):
        """Its Part, compiled or loaded if need be."""
        kernel = getattr(import_module(self.module), self.name)
        kernel.compile(self.arguments)
        return kernel.overloads[self.arguments].library


class Part(JITCodeLibrary):
    """LLVM code of a kernel that others call.

    source: Source. inlined: whether it becomes part of its callers; if not, it is optimised here. symbol: its name in
    LLVM. calls: the kernels that it calls, a Part or a Source that has not been looked up yet; of one not inlined,
    those not inlined either.
    """

    def __init__(self, codegen, name, source, inlined, symbol=""):
        super().__init__(codegen, name)
        self.source = source
        self.inlined = inlined
        self.symbol = symbol
        self.calls = []

    def finalize(self):
        self.calls = linked(self)
        if not self.inlined:
            self.calls = absorbed(self, self.calls)
            self._optimize_final_module()
            # Taken for rare: beside a call that is not made numbers stay in registers. It makes steps 2 % shorter, with
            # one more such call in the loop over wheels 20 % (fastest of 300 marches in turn).
            self._final_module.get_function(self.symbol).add_function_attribute("cold")
        self._final_module.verify()
        self._finalized = True

    def called(self):
        """The same, looked up: Parts."""
        self.calls = [call.library() if isinstance(call, Source) else call for call in self.calls]
        return self.calls

    def module(self):
        """Its code, to be linked into that of a caller."""
        if self._shared_module is None:
            self._shared_module = self._final_module.clone()
            for function in self._shared_module.functions:
                if not function.is_declaration and function.linkage == llvm.Linkage.external:
                    function.linkage = "linkonce_odr"
        return self._shared_module

    def get_pointer_to_function(self, name):
        return 0  # of no machine code

    def _get_module_for_linking(self):
        """The code of all that it needs, for functions that are no kernels of ours and call it."""
        whole = self.module().clone()
        for part in reached([self]):
            if part is not self:
                whole.link_in(part.module(), preserve=True)
        return whole


class Entry(MachineCode):
    """LLVM code of a kernel that Python calls, and of all that it needs; machine code at the end."""

    def finalize(self):
        self.own = seen(self._final_module)  # which Numba asks for
        link_all(self)
        self._finalize_final_module()


def link_all(library):
    """Optimise a library with the inlined kernels that it calls, and link all outlined ones that it needs."""
    calls = absorbed(library, linked(library))
    library._optimize_final_module()
    for part in reached(calls):
        if not part.inlined:
            library._final_module.link_in(part.module(), preserve=True)
    hand_over_less(library)
    library._final_module.verify()


def hand_over_less(library):
    """Let outlined kernels be given what they use, and no more.

    Every array and every number of a record is an argument by itself, some 400 of most kernels, which read a few.
    """
    module = library._final_module
    for function in list(module.functions):
        if not function.is_declaration and function.linkage != llvm.Linkage.external:
            function.linkage = "internal"  # nobody else calls it, and who asks for it by its name gets the whole one
            function.name += ".trimmed"
    passes = llvm.create_new_module_pass_manager()
    passes.add_dead_arg_elimination_pass()
    passes.add_aggressive_dce_pass()
    passes.run(module, library._codegen._pass_builder())


def linked(library):
    """The Parts that a library calls, after what else it calls has been linked in."""
    libraries = dict.fromkeys(library._linking_libraries)
    for other in libraries:
        if not isinstance(other, Part):
            library._final_module.link_in(other._get_module_for_linking(), preserve=True)
    return [other for other in libraries if isinstance(other, Part)]


def absorbed(library, calls):
    """The Parts that a library still calls after all inlined ones have been linked in."""
    found = reached(calls, through=lambda part: part.inlined)
    for part in found:
        if part.inlined:
            library._final_module.link_in(part.module(), preserve=True)
    return [part for part in found if not part.inlined]


def reached(parts, through=lambda _: True):
    """These Parts and all that they call, but not beyond those that `through` denies, each before those that it calls:
    LLVM drops what nothing calls yet, also what is called later on where the only call before has been optimised
    away."""
    found = {}

    def visit(part):
        if part in found:
            return
        found[part] = None
        if through(part):
            for call in part.called():
                visit(call)
        del found[part]
        found[part] = None  # after those that it calls

    for part in parts:
        visit(part)
    return list(reversed(found))


class KernelLowering(NativeLowering):
    """Numba's step from its own code to that of LLVM, with names that are short and the same in every process: the
    types in them would fill thousands of characters."""

    def __init__(self):
        NativeLowering.__init__(self)

    def run_pass(self, state):
        context, function = state.targetctx, state.func_id
        function.unique_id = 0
        context.mangler = mangled
        try:
            return self.lower(state, context.codegen(), function)
        finally:
            del context.mangler

    def lower(self, state, codegen, function):
        raise NotImplementedError


def mangled(name, arguments, *, abi_tags=(), uid=None):
    """Name of a function in LLVM, by its own and a digest of the types of its arguments."""
    digest = hashlib.sha256(repr(arguments).encode()).hexdigest()[:16]
    return itanium_mangler.mangle(name, (digest,), abi_tags=abi_tags, uid=uid)


@register_pass(mutates_CFG=True, analysis_only=False)
class PartLowering(KernelLowering):
    _name = "part_lowering"

    def lower(self, state, codegen, function):
        flags = state.flags
        source = Source(function.modname, function.func_qualname, tuple(state.args))
        flags.no_compile = flags.no_cpython_wrapper = True
        state.library = library = Part(codegen, function.func_qualname, source, flags.forceinline)
        super(KernelLowering, self).run_pass(state)
        lowered = state["cr"]
        library.symbol = lowered.fndesc.mangled_name
        library.finalize()
        state["cr"] = lowered._replace(cfunc=token(lowered.fndesc, lowered.env, library))
        state.targetctx.insert_user_function(state["cr"].cfunc, lowered.fndesc, [library])
        return True


@register_pass(mutates_CFG=True, analysis_only=False)
class EntryLowering(KernelLowering):
    _name = "entry_lowering"

    def lower(self, state, codegen, function):
        state.library = Entry(codegen, function.func_qualname)
        return super(KernelLowering, self).run_pass(state)


def token(descriptor, environment, library):
    """What stands for the machine code of a Part where Numba wants it: something to know it by, not to be called."""
    return _dynfunc.make_function(
        descriptor.lookup_module(), descriptor.qualname, "part of a kernel", 0, environment, (library,)
    )


SIGNATURES: dict[tuple, object] = {}  # of what kernels call, by function and types of arguments
FOUND_BY_NUMBA = BaseFunction.get_call_type


@contextmanager
def remembered_signatures() -> Iterator[None]:
    """Numba goes through dozens of templates for every sum of two numbers, in every kernel anew; what it has found for
    the same types stands: a sixth of the time."""
    before = BaseFunction.get_call_type  # what is here, where one kernel is compiled for another
    BaseFunction.get_call_type = remembered
    try:
        yield
    finally:
        BaseFunction.get_call_type = before


def remembered(function, context, arguments, by_name):
    key = function, tuple(arguments), tuple(by_name.items())
    if key not in SIGNATURES:
        SIGNATURES[key] = FOUND_BY_NUMBA(function, context, arguments, by_name)
    return SIGNATURES[key]


class KernelCompiler(Compiler):
    """Numba's compiler, told that no two arrays that a kernel is given overlap where it writes, to leave out what is
    not there, and how to link. lowering: its last step."""

    lowering: type

    def compile_extra(self, function):
        with remembered_signatures():
            return super().compile_extra(function)

    def define_pipelines(self):
        self.state.flags.noalias = True
        first, *others = super().define_pipelines()
        first.add_pass_after(FoldAbsent, RewriteSemanticConstants)
        first.passes = [(self.lowering if step is NativeLowering else step, why) for step, why in first.passes]
        first.finalize()
        return [first, *others]


class PartCompiler(KernelCompiler):
    lowering = PartLowering


class EntryCompiler(KernelCompiler):
    lowering = EntryLowering


class PartResults(CompileResultCacheImpl):
    """How a compiled Part is kept on disk."""

    def reduce(self, result):
        part, descriptor = result.library, result.fndesc
        descriptor.typemap = descriptor.calltypes = None
        calls = [call if isinstance(call, Source) else call.source for call in part.calls]
        code = part._final_module.as_bitcode()
        return part.name, part.source, part.inlined, code, calls, descriptor, result.environment, result.signature

    def rebuild(self, target_context, payload):
        name, source, inlined, code, calls, descriptor, environment, signature = payload
        part = Part(target_context.codegen(), name, source, inlined, descriptor.mangled_name)
        part._final_module = llvm.parse_bitcode(code)
        part.calls = calls
        part._finalized = True
        return restored(target_context, part, token(descriptor, environment, part), descriptor, environment, signature)


class EntryResults(CompileResultCacheImpl):
    """How a compiled Entry is kept on disk."""

    def reduce(self, result):
        entry, descriptor = result.library, result.fndesc
        descriptor.typemap = descriptor.calltypes = None
        kept = entry.name, entry.object_file, entry.exported, entry.imported
        return *kept, descriptor, result.environment, result.signature

    def rebuild(self, target_context, payload):
        name, object_file, exported, imported, descriptor, environment, signature = payload
        entry = Entry(target_context.codegen(), name)
        entry.load(object_file, exported, imported)
        function = target_context.get_executable(entry, descriptor, environment)
        return restored(target_context, entry, function, descriptor, environment, signature)


def restored(target_context, library, function, descriptor, environment, signature):
    """What Numba has of a compiled function, from what was kept. function: what Python calls."""
    return CompileResult(
        typing_context=target_context.typing_context,
        target_context=target_context,
        entry_point=function,
        typing_error=None,
        type_annotation="",
        signature=signature,
        objectmode=False,
        lifted=(),
        fndesc=descriptor,
        library=library,
        call_helper=None,
        environment=environment,
        metadata=None,
        reload_init=[],
        referenced_envs=[],
    )
