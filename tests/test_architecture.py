"""The drawing of the house, held by reading the imports: who may know whom, and what `import skillfold` loads."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import skillfold

ROOT = Path(skillfold.__file__).parent

# Each floor may import from floors above it in this list, and from itself.
FLOORS = [
    {"errors"},
    {"ahead", "jit", "lanes", "spaces", "tables"},
    {
        "motion",
        "check",
        "clearance",
        "archive",
        "demonstrations",
        "recordings",
        "alignment",
        "consistency",
        "crossings",
        "worst",
    },
    {"robots", "planning"},
    {"manifold", "keyframes"},
    {"control"},
    {"baselines", "experiments", "viewing", "io", "cli"},
]
STRANGERS = [("manifold", "keyframes"), ("keyframes", "manifold"), ("check", "robots"), ("manifold", "robots")]
# Readers and writers of files are asked for by name, inside the methods that need them.
ALLOWED = {
    ("skillfold.demonstrations", "skillfold.io.recording_files"),
    ("skillfold.control.rollout", "skillfold.io.rollout_files"),
}

HEAVY = ("numba", "mujoco", "matplotlib", "sklearn", "scipy", "viser", "joblib", "pandas", "tyro")
HOMES = {
    "matplotlib": ("viewing/",),
    "viser": ("viewing/",),
    "mujoco": ("robots/", "control/simulate.py"),
    "tyro": ("cli/", "cli.py"),
    "ompl": ("experiments/ompl_peer.py", "experiments/keyframe_ompl.py"),
    "numba": ("jit.py", "lanes.py", "tables.py", "robots/mujoco_calls.py"),
    "llvmlite": ("lanes.py", "robots/mujoco_calls.py"),
}
LINES = 300
# Of `np.random`, what makes no use of NumPy's one global generator.
OWN_GENERATORS = {"default_rng", "Generator", "RandomState", "SeedSequence", "PCG64", "BitGenerator"}


def module_of(file):
    parts = file.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


FILES = {module_of(file): file for file in sorted(ROOT.rglob("*.py"))}
TREES = {module: ast.parse(file.read_text(encoding="utf-8")) for module, file in FILES.items()}


def for_types_only(node):
    test = node.test
    return (test.id if isinstance(test, ast.Name) else getattr(test, "attr", "")) == "TYPE_CHECKING"


def imports(module):
    """(imported module, whether at the top level) of every import that runs, as written."""
    found = []

    def walk(nodes, top):
        for node in nodes:
            if isinstance(node, ast.If) and for_types_only(node):
                walk(node.orelse, top)
                continue
            if isinstance(node, ast.Import):
                found.extend((alias.name, top) for alias in node.names)
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{module}: relative import"
                for alias in node.names:
                    whole = f"{node.module}.{alias.name}"
                    found.append((whole if whole in FILES else node.module, top))
            inner = top and not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
            walk(ast.iter_child_nodes(node), inner)

    walk(TREES[module].body, True)
    return found


def own_imports(module):
    return [(name, top) for name, top in imports(module) if name.split(".")[0] == "skillfold"]


def room(module):
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else ""


def floor(module):
    found = [i for i, rooms in enumerate(FLOORS) if room(module) in rooms]
    assert found, f"{module} has no floor: name its room in FLOORS"
    return found[0]


MODULES = [module for module in FILES if module not in ("skillfold", "skillfold.__main__")]


@pytest.mark.parametrize("module", MODULES)
def test_imports_go_down_or_stay_in_the_room(module):
    for name, top in own_imports(module):
        if name == "skillfold":
            # The package itself: names that load on first use, only for rooms that stand on top of all.
            assert floor(module) == len(FLOORS) - 1, f"{module} imports skillfold as a whole"
            continue
        if (module, name) in ALLOWED:
            assert not top, f"{module} imports {name} at its top level"
            continue
        assert floor(name) <= floor(module), f"{module} imports {name} from above"
        assert (room(module), room(name)) not in STRANGERS, f"{module} must not know {name}"


def test_the_ways_up_are_used():
    """Else the exceptions would stand for nothing."""
    assert {(m, name) for m in MODULES for name, _ in own_imports(m)} >= ALLOWED


def test_there_are_no_circles_between_modules():
    graph = {m: {name for name, _ in own_imports(m) if (m, name) not in ALLOWED} - {m} for m in FILES}
    done, path = set(), []

    def visit(module):
        assert module not in path, "circle: " + " → ".join([*path[path.index(module) :], module])
        if module in done:
            return
        path.append(module)
        for name in sorted(graph.get(module, ())):
            # A package's own `__init__` runs first, whoever asks.
            visit(name)
        path.pop()
        done.add(module)

    for module in graph:
        visit(module)


def test_skillfold_itself_imports_nothing_heavy_nor_any_room():
    assert own_imports("skillfold") == []


@pytest.mark.parametrize("library", HOMES)
def test_outside_libraries_stay_in_their_rooms(library):
    for module, file in FILES.items():
        used = any(name.split(".")[0] == library for name, _ in imports(module))
        home = file.relative_to(ROOT).as_posix().startswith(HOMES[library])
        assert home or not used, f"{module} imports {library}, which belongs in {', '.join(HOMES[library])}"


def test_the_robot_is_unknown_to_manifold_and_check():
    for module in MODULES:
        if room(module) in ("manifold", "check"):
            assert not any(name.startswith("skillfold.robots") for name, _ in imports(module))


def fresh(code):
    """What a new interpreter prints."""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    return run.stdout.split()


def test_import_skillfold_is_light():
    code = f"import skillfold, sys; print(*(name for name in {HEAVY!r} if name in sys.modules))"
    assert fresh(code) == []
    assert "numpy" not in fresh("import skillfold, sys; print(*sys.modules)")


@pytest.mark.parametrize("name", ["Demonstrations", "StateSpace", "Plan", "SkillfoldError"])
def test_light_names_stay_light(name):
    heavy = ("numba", "mujoco", "matplotlib", "sklearn", "viser")
    code = f"import skillfold, sys; skillfold.{name}; print(*(n for n in {heavy!r} if n in sys.modules))"
    assert fresh(code) == []


@pytest.mark.parametrize("name", skillfold.__all__)
def test_every_public_name_is_there(name):
    assert getattr(skillfold, name) is not None
    assert name in dir(skillfold)


def test_public_names_that_editors_see_are_those_that_load():
    seen = {
        alias.asname
        for node in ast.walk(TREES["skillfold"])
        if isinstance(node, ast.If) and for_types_only(node)
        for line in node.body
        if isinstance(line, ast.ImportFrom)
        for alias in line.names
    }
    assert seen == set(skillfold._HOME)


def test_an_unknown_name_says_what_there_is():
    with pytest.raises(AttributeError, match=r"no attribute 'Manifold'; it has .*SkillManifold"):
        skillfold.Manifold  # noqa: B018


@pytest.mark.parametrize("module", FILES)
def test_files_are_short(module):
    lines = FILES[module].read_text(encoding="utf-8").count("\n")
    assert lines <= LINES, f"{module} has {lines} lines, more than {LINES}"


@pytest.mark.parametrize("module", FILES)
def test_the_library_does_not_print(module):
    if room(module) == "cli":
        return
    calls = [node.func for node in ast.walk(TREES[module]) if isinstance(node, ast.Call)]
    assert not [f for f in calls if isinstance(f, ast.Name) and f.id in ("print", "input", "breakpoint")]


@pytest.mark.parametrize("module", FILES)
def test_no_global_random_state(module):
    for node in ast.walk(TREES[module]):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Attribute) and node.value.attr == "random":
            owner = node.value.value
            if isinstance(owner, ast.Name) and owner.id in ("np", "numpy"):
                assert node.attr in OWN_GENERATORS, f"{module}, line {node.lineno}: np.random.{node.attr}"
    names = [name for name, _ in imports(module)]
    assert not [name for name in names if name.split(".")[0] == "random"]
    assert "numpy.random" not in names


@pytest.mark.parametrize("module", FILES)
def test_nothing_is_unpickled_or_run_from_text(module):
    names = {name.split(".")[0] for name, _ in imports(module)}
    assert not names & {"pickle", "marshal", "shelve", "dill", "cloudpickle"}
    calls = [node.func for node in ast.walk(TREES[module]) if isinstance(node, ast.Call)]
    assert not [f for f in calls if isinstance(f, ast.Name) and f.id in ("eval", "exec", "compile")]


@pytest.mark.parametrize("module", FILES)
def test_every_module_says_what_it_is(module):
    assert ast.get_docstring(TREES[module]), f"{module} has no docstring"
