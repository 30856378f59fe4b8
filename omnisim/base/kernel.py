"""The one decorator of every compiled function, and the cache that never runs stale code.

Numba's own cache looks at the file of the decorated function only: after an edit in another file a cached caller
would keep running the old callee. So the cache folder is named after a hash of all sources that kernels depend on,
which plots and exports are not.
"""

import hashlib
import os
import re
import shutil
import tempfile
import warnings
from functools import cached_property
from pathlib import Path

import numba
import platformdirs
from numba.core import config as numba_config
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.registry import CPUDispatcher
from numba.core.types import unliteral

from omnisim.base.compiler import EntryCompiler, EntryResults, PartCompiler, PartResults

NAME = re.compile(r"[\w.]+")
OPTIONS = {
    "nopython": True,
    "boundscheck": None,
    "error_model": "numpy",
    "_nrt": False,
    "nogil": True,  # other threads of Python run meanwhile
    "fastmath": {"contract"},
    "no_cfunc_wrapper": True,  # nobody calls kernels from C
}
KEPT_CACHES = 4  # how many cache folders of other versions of the sources survive


def source_hash(package: Path = Path(__file__).parents[1]) -> str:
    """Hash of the sources that compiled code depends on, and of the version of Numba."""
    digest = hashlib.sha256(numba.__version__.encode())
    for path, source in kernel_sources(package).items():
        digest.update(path.relative_to(package).as_posix().encode() + b"\0" + source)
    return digest.hexdigest()[:16]


def kernel_sources(package: Path) -> dict[Path, bytes]:
    """The modules that import a decorator of this one, to define kernels, and whatever they import in turn."""
    sources = {path: path.read_bytes() for path in sorted(package.rglob("*.py"))}
    names = {path: dotted(path, package.parent) for path in sources}
    imports = {path: imported(source, names[path], path.stem == "__init__") for path, source in sources.items()}
    home = dotted(Path(__file__), Path(__file__).parents[2])
    decorators = {f"{home}.kernel", f"{home}.outlined"}
    reached = set()
    more = {path for path in sources if not decorators.isdisjoint(imports[path])}
    while more:
        reached |= more
        wanted = {name for path in more for name in imports[path]}
        more = {path for path in sources if names[path] in wanted} - reached
    return {path: sources[path] for path in sources if path in reached}


def dotted(path: Path, root: Path) -> str:
    """The name under which a file below `root` is imported."""
    return ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__")


def imported(source: bytes, name: str, is_package: bool) -> set[str]:
    """All that a module of this name may import: every dotted name, and word within one, beside the word "import".

    Comments may add some. Parsing would add none, and take a hundred times as long.
    """
    found: set[str] = set()
    before, *rest = source.replace(b"\\\n", b" ").decode().split("import")
    for after in rest:
        end = "\n)" if after.lstrip().startswith("(") else "\n"
        listed = NAME.findall(after.partition(end)[0])
        origin = NAME.findall(before.rpartition("\n")[2].rpartition("from ")[2])
        base = absolute(origin[-1], name, is_package) if origin else ""
        found.update(listed, (base,), (f"{base}.{word}" for word in listed))
        before = after
    return found


def absolute(origin: str, name: str, is_package: bool) -> str:
    """What follows "from" in the module `name`, without leading dots."""
    below = origin.lstrip(".")
    up = len(origin) - len(below)
    if up == 0:
        return origin
    parts = name.split(".") + ["__init__"] * is_package
    return ".".join([*parts[: len(parts) - up], *([below] if below else [])])


def cache_directory() -> Path:
    """A writable folder for kernels of exactly these sources.

    Below NUMBA_CACHE_DIR if the user set it, else in the user's cache folder, else (nothing is writable) a
    temporary one. Older folders beside it are pruned.
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    base = Path(chosen) / "omnisim" if chosen else platformdirs.user_cache_path("omnisim", appauthor=False)
    directory = base / source_hash()
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=directory):
            pass
        os.utime(directory)
    except OSError:
        return temporary_directory()
    prune(base, directory)
    return directory


def temporary_directory() -> Path:
    """A folder of this user alone, since Numba trusts what it finds there."""
    user = os.getuid() if hasattr(os, "getuid") else 0
    directory = Path(tempfile.gettempdir()) / f"omnisim-{user}"
    directory.mkdir(mode=0o700, exist_ok=True)
    found = directory.lstat()
    private = hasattr(os, "getuid") and found.st_uid == user and not found.st_mode & 0o077
    return (directory if private else Path(tempfile.mkdtemp(prefix="omnisim-"))) / source_hash()


def prune(base: Path, current: Path) -> None:
    """Remove all but the most recently used cache folders; another process may be doing the same."""
    try:
        others = [path for path in base.iterdir() if path.is_dir() and path != current]
        others.sort(key=lambda path: path.stat().st_mtime, reverse=True)
    except OSError:
        return
    for path in others[KEPT_CACHES:]:
        shutil.rmtree(path, ignore_errors=True)


CACHE_DIRECTORY = cache_directory()


def kernel(function):
    """Compile `function` with Numba on first use, cached on disk, and inline it wherever it is called.

    Arithmetic as NumPy has it, NaN included, but for products that are added: processors that can do both at once round
    once.
    """
    return compiled(function, inline=True)


def outlined(function):
    """A kernel that is called, not inlined: for what is rare, or long with many uses, where compiling counts more."""
    return compiled(function, inline=False)


class KernelFiles(IndexDataCacheFile):
    """A file for every kernel and signature, named after both.

    Numba numbers the files and keeps an index: two processes that compile at once could give one number to two
    signatures, and the one would run the other's code.
    """

    def save(self, key, data):
        try:
            self._save_data(self._name(key), data)
        except OSError as error:  # a full disk is no reason to lose a run
            warnings.warn(
                f"{CACHE_DIRECTORY}: compiled kernels cannot be kept: {error.strerror}", RuntimeWarning, stacklevel=2
            )

    def load(self, key):
        try:
            return self._load_data(self._name(key))
        except OSError:  # not there
            return None

    def _name(self, key):
        return f"{Path(self._index_name).stem}{self.kind}.{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.nbc"


class KernelCache(FunctionCache):
    """What is kept of one function."""

    def load_overload(self, sig, target_context):
        """As Numba's, which first makes ready all that it could compile with: that takes longer than all else."""
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)


class Keeping(CPUDispatcher):
    """A dispatcher that can keep what it compiles."""

    def keep(self, results, kind=""):
        """Let it do so; itself. results: how, a class of Numba's CompileResultCacheImpl; kind: what tells its files
        from others of the function."""
        del self._cache  # Numba's, which keeps nothing
        self.results, self.kind = results, kind
        return self

    @cached_property
    def _cache(self):
        """Found when it is first asked for: most functions are part of others that are there.

        Numba reads its cache folder here, so the setting is put back at once: other packages keep theirs.
        """
        theirs = numba_config.CACHE_DIR
        numba_config.CACHE_DIR = str(CACHE_DIRECTORY)
        try:
            cache = KernelCache(self.py_func)
        finally:
            numba_config.CACHE_DIR = theirs
        cache._impl.__class__ = self.results
        files = cache._cache_file
        files.__class__, files.kind = KernelFiles, self.kind
        return cache


class Kernel(Keeping):
    """A compiled function that others call; what Python calls is its `entry`, compiled when it does so first."""

    def __call__(self, *arguments):
        return self.entry(*arguments)

    @cached_property
    def entry(self):
        dispatcher = Keeping(self.py_func, targetoptions=dict(OPTIONS), pipeline_class=EntryCompiler)
        return dispatcher.keep(EntryResults, ".entry")

    @cached_property
    def apart(self):
        """The same, optimised by itself as its `entry` is, for code of C that calls it: inlined there, where all sizes
        are known, its sums would round otherwise."""
        dispatcher = Kernel(self.py_func, targetoptions=OPTIONS | {"forceinline": False}, pipeline_class=PartCompiler)
        return dispatcher.keep(PartResults, ".apart")

    def compile(self, signature):
        """Compile for the types of the arguments alone.

        Numba would do it again for every constant that a caller hands over, and its own optimiser finds those anyway
        where it inlines.
        """
        return super().compile(tuple(map(unliteral, signature)) if isinstance(signature, tuple) else signature)


def compiled(function, inline):
    if numba_config.DISABLE_JIT:
        return function
    options = OPTIONS | {"forceinline": inline}
    return Kernel(function, targetoptions=options, pipeline_class=PartCompiler).keep(PartResults)
