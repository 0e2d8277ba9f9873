"""Shapes and scenes: what they accept, what they refuse, and JSON both ways."""

import json
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skillfold as sf
from robots import scenes
from skillfold.errors import InputError, SceneError, SkillfoldError
from skillfold.robots.poses import between, compose, place_points

LAWS = settings(max_examples=30, deadline=None)
CUBE = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
HERE = (0, 0, 0)


@given(seed=st.integers(0, 9999), moving=st.booleans())
@LAWS
def test_scenes_come_back_from_json_as_they_were(tmp_path_factory, seed, moving):
    scene = scenes.one_of_each(seed)
    if moving:
        rng = np.random.default_rng(seed)
        motion = sf.Motion([0, 0.1, 3], np.stack([scenes.pose(rng) for _ in range(3)]))
        ball = sf.Sphere(center=HERE, radius=1, name="ball ü", motion=motion)
        scene = sf.Scene([*scene, ball])
    file = tmp_path_factory.mktemp("scenes") / "scene.json"
    scene.save(file)
    again = sf.Scene.load(file)
    assert again == scene
    assert again.to_json() == scene.to_json()
    assert again.names == scene.names


def test_json_by_hand(tmp_path):
    (tmp_path / "wedge.obj").write_text("v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 100\nf 1 2 3\n")
    text = """{"obstacles": [
        {"shape": "box", "name": "table", "pose": [0.6, 0, 0.2], "size": [0.4, 0.8, 0.4]},
        {"shape": "sphere", "center": [0, 0, 1], "radius": 0.1,
         "motion": {"times": [0, 1], "poses": [[0, 0, 1], [0, 0, 2]]}},
        {"shape": "mesh", "file": "wedge.obj", "scale": 0.001, "pose": [1, 0, 0]}]}"""
    (tmp_path / "scene.json").write_text(text)
    scene = sf.Scene.load(tmp_path / "scene.json")
    assert scene.names == ("table", "sphere_1", "mesh_2")
    assert scene["table"].pose == (0.6, 0, 0.2, 1, 0, 0, 0)
    assert scene["sphere_1"].at(0.5)[2] == pytest.approx(1.5)
    assert np.max(scene["mesh_2"].vertices) == pytest.approx(0.1)
    assert len(scene) == 3
    assert repr(scene) == "Scene(table, sphere_1, mesh_2)"


BAD_JSON = [
    ("[", "no JSON"),
    ("[]", 'expected {"format"'),
    ('{"obstacles": 3}', 'expected {"format"'),
    ('{"format": "other", "obstacles": []}', "format 'other'"),
    ('{"version": 2, "obstacles": []}', "version 2"),
    ('{"obstacles": [7]}', "obstacle 0: shape 7; possible: box, sphere"),
    ('{"obstacles": [{"shape": "torus"}]}', "shape 'torus'; possible"),
    ('{"obstacles": [{"shape": ["box"]}]}', "possible"),
    ('{"obstacles": [{"shape": "box", "pose": [0,0,0]}]}', "box with pose; expected .*size"),
    ('{"obstacles": [{"shape": "box", "pose": [0,0,0], "size": [1,1,1], "colour": 1}]}', "unknown entries colour"),
    ('{"obstacles": [{"shape": "box", "pose": [0,0,0], "size": [1,-1,1]}]}', "obstacle 0: Box: size"),
    ('{"obstacles": [{"shape": "box", "pose": [0,0,NaN], "size": [1,1,1]}]}', "not finite"),
    ('{"obstacles": [{"shape": "mesh", "file": 3}]}', "expected a path"),
    ('{"obstacles": [{"shape": "mesh", "file": "no.obj"}]}', "no.obj: cannot be read"),
    ('{"obstacles": [{"shape": "sphere", "center": [0,0,0], "radius": 1, "motion": []}]}', "motion"),
    (
        '{"obstacles": [{"shape": "sphere", "center": [0,0,0], "radius": 1, "motion": {"times": [], "poses": []}}]}',
        "obs",
    ),
]


@pytest.mark.parametrize(("text", "message"), BAD_JSON)
def test_files_that_are_no_scenes_say_why(tmp_path, text, message):
    file = tmp_path / "scene.json"
    file.write_text(text)
    with pytest.raises(SceneError, match=message) as caught:
        sf.Scene.load(file)
    assert "scene.json" in str(caught.value)


VALUES = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5) | st.sampled_from(["box", "mesh"]),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(["shape", "pose", "size", "radius", "center", "obstacles", "motion", "vertices", "file"]),
            inner,
            max_size=4,
        )
    ),
    max_leaves=12,
)


@given(data=VALUES)
@settings(max_examples=150, deadline=None)
def test_no_json_raises_anything_else(data):
    for whole in (data, {"obstacles": data}, {"obstacles": [data]}, {"obstacles": [{"shape": "box", "size": data}]}):
        try:
            sf.Scene.from_json(whole)
        except SkillfoldError as error:
            assert str(error)


def test_files_that_cannot_be_read_or_written(tmp_path):
    with pytest.raises(SceneError, match="cannot be read"):
        sf.Scene.load(tmp_path / "none.json")
    with pytest.raises(SceneError, match="cannot be written"):
        sf.Scene([]).save(tmp_path)


REFUSED = [
    (lambda: sf.Box(pose=(0, 0), size=(1, 1, 1)), r"Box: pose: shape \(2,\)"),
    (lambda: sf.Box(pose=(0, 0, 0, 1, 1, 0, 0), size=(1, 1, 1)), "length 1.414; expected length 1"),
    (lambda: sf.Box(pose=[HERE], size=(1, 1, 1)), "pose of shape"),
    (lambda: sf.Box(pose=(0, 0, np.nan), size=(1, 1, 1)), "not finite"),
    (lambda: sf.Box(pose=(0, 0, 0, 1e300, 0, 0, 0), size=(1, 1, 1)), "expected length 1"),
    (lambda: sf.Box(pose=(1e300, 0, 0), size=(1, 1, 1)), "in metres"),
    (lambda: sf.Box(pose=(10**400, 0, 0), size=(1, 1, 1)), "expected a pose"),
    (lambda: sf.Box(pose=np.array(HERE) * 1j, size=(1, 1, 1)), "expected a pose"),
    (lambda: sf.Mesh.read("none.obj", scale="mm"), "scale 'mm'; expected a number"),
    (lambda: sf.Box(pose="here", size=(1, 1, 1)), "'here'; expected a pose"),
    (lambda: sf.Box(pose=HERE, size=(1, 1, 0), name="table"), "Box 'table': size .* full edge lengths"),
    (lambda: sf.Box(pose=HERE, size=1), "three"),
    (lambda: sf.Box(pose=(1e6, 0, 0), size=(1, 1, 1)), "positions are in metres"),
    (lambda: sf.Sphere(center=(0, 0), radius=1), "center"),
    (lambda: sf.Sphere(center=HERE, radius=0), "radius is 0; expected a positive length"),
    (lambda: sf.Sphere(center=HERE, radius=[1, 2]), "radius"),
    (lambda: sf.Sphere(center=HERE, radius=np.inf), "not finite"),
    (lambda: sf.Cylinder(pose=HERE, radius=1, length=-2), "length is -2"),
    (lambda: sf.Capsule(pose=HERE, radius=None, length=1), "radius"),
    (lambda: sf.Mesh(CUBE[:3]), "3 vertices without volume"),
    (lambda: sf.Mesh([(x, y, 0) for x, y, _ in CUBE]), "without volume"),
    (lambda: sf.Mesh(np.zeros((5, 2))), r"points \(n, 3\)"),
    (lambda: sf.PointCloud([], 0.1), r"points \(n, 3\)"),
    (lambda: sf.PointCloud([(0, 0, np.inf)], 0.1), "not finite"),
    (lambda: sf.PointCloud([(0, 0, 1e7)], 0.1), "in metres"),
    (lambda: sf.PointCloud([HERE], 0), "radius"),
    (lambda: sf.Box(pose=HERE, size=(1, 1, 1), name=3), "name 3; expected a text"),
    (lambda: sf.Box(pose=HERE, size=(1, 1, 1), motion=[0, 1]), "motion is a list"),
    (lambda: sf.Motion([0, 0], [HERE, HERE]), "time 0 follows 0"),
    (lambda: sf.Motion([0], [HERE, HERE]), "times"),
    (lambda: sf.Motion([], np.zeros((0, 3))), "times"),
    (lambda: sf.Scene(sf.Sphere(center=HERE, radius=1)), "expected a list of shapes: Box, Sphere"),
    (lambda: sf.Scene(3), "expected a list"),
    (lambda: sf.Scene([HERE]), "obstacle 0 is a tuple"),
    (lambda: sf.Scene([sf.Sphere(center=HERE, radius=1, name="a")] * 2), "several obstacles are named a"),
    (lambda: sf.Scene([])["a"], "no obstacle 'a'; there are none"),
    (lambda: scenes.boxes(1).moved("box_0", (1, 2)), "pose"),
]


@pytest.mark.parametrize(("make", "message"), REFUSED)
def test_what_is_no_obstacle_says_why(make, message):
    with pytest.raises(SceneError, match=message) as caught:
        make()
    assert isinstance(caught.value, InputError)


def test_shapes_are_frozen_and_compare_by_what_they_are():
    box = sf.Box(pose=HERE, size=[1, 2, 3])
    assert box == sf.Box(pose=(0, 0, 0, 1, 0, 0, 0), size=(1, 2, 3))
    assert box != sf.Box(pose=HERE, size=(1, 2, 3), name="x")
    assert box != sf.Sphere(center=HERE, radius=1)
    assert len({box, sf.Box(pose=HERE, size=(1, 2, 3))}) == 1
    with pytest.raises(AttributeError):
        box.size = (1, 1, 1)
    cloud = sf.PointCloud(np.ones((2, 3)), 0.1)
    with pytest.raises(ValueError, match="read-only"):
        cloud.points[0] = 0


def test_arrays_given_stay_the_givers():
    points = np.ones((4, 3))
    cloud = sf.PointCloud(points, 0.1)
    points[:] = 7
    assert (cloud.points == 1).all()


def test_a_mesh_is_its_hull():
    inside = np.random.default_rng(0).uniform(0.1, 0.9, (50, 3))
    mesh = sf.Mesh([*CUBE, *inside])
    assert {tuple(v) for v in mesh.vertices} == {tuple(map(float, v)) for v in CUBE}


def binary_stl(corners):
    triangles = [struct.pack("<12fH", *[0.0] * 3, *np.ravel(corners[i : i + 3]), 0) for i in range(len(corners) - 2)]
    return b"\0" * 80 + struct.pack("<I", len(triangles)) + b"".join(triangles)


def test_meshes_from_files(tmp_path):
    (tmp_path / "a.obj").write_text("# cube\n" + "".join(f"v {x} {y} {z}\n" for x, y, z in CUBE) + "f 1 2 3\n")
    (tmp_path / "b.stl").write_bytes(binary_stl(CUBE))
    ascii_stl = "solid c\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in CUBE) + "endsolid"
    (tmp_path / "c.STL").write_text(ascii_stl)
    for name in ("a.obj", "b.stl", "c.STL"):
        mesh = sf.Mesh.read(tmp_path / name, (1, 2, 3), scale=0.5, name="cube")
        assert np.max(mesh.vertices) == 0.5
        assert mesh.name == "cube"
        assert mesh.pose[:3] == (1, 2, 3)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.dae", b"", "possible: .obj, .stl"),
        ("a.obj", b"v 1 2\nv 1 2 3", "damaged"),
        ("a.obj", b"v 1 2 x\n" * 5, "damaged"),
        ("a.obj", b"hello", "0 vertices"),
        ("a.stl", b"\1" * 100, "do not hold the"),
        ("a.stl", b"solid\nvertex 1 2 3", "1 vertices"),
        ("a.stl", binary_stl([(np.nan,) * 3] * 6), "vertices"),
    ],
)
def test_mesh_files_that_cannot_be_used_say_why(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(SceneError, match=message):
        sf.Mesh.read(tmp_path / name)


def test_windows_marks_of_text_are_no_trouble(tmp_path):
    file = tmp_path / "scene.json"
    scenes.boxes(1).save(file)
    file.write_bytes(b"\xef\xbb\xbf" + file.read_bytes())
    assert sf.Scene.load(file) == scenes.boxes(1)


def test_motion_turns_evenly_the_shorter_way():
    turned = (np.cos(0.5), 0, 0, np.sin(0.5))
    motion = sf.Motion([0, 2], [(0, 0, 0, 1, 0, 0, 0), (2, 0, 0, *(-np.array(turned)))])
    half = motion.at(0.5)
    np.testing.assert_allclose(half[:3], [0.5, 0, 0])
    assert abs(half[3:] @ [np.cos(0.125), 0, 0, np.sin(0.125)]) == pytest.approx(1)
    np.testing.assert_allclose(motion.at(-1), motion.poses[0])
    np.testing.assert_allclose(motion.at(2.5), motion.poses[1])


@given(seed=st.integers(0, 9999))
@LAWS
def test_poses_compose_as_they_place_points(seed):
    rng = np.random.default_rng(seed)
    a, b, points = scenes.pose(rng), scenes.pose(rng), rng.normal(size=(4, 3))
    np.testing.assert_allclose(
        place_points(compose(a, b), points), place_points(a, place_points(b, points)), atol=1e-12
    )
    np.testing.assert_allclose(between(a, b, 0.0), a, atol=1e-12)
    end = between(a, b, 1.0)
    np.testing.assert_allclose(end[:3], b[:3], atol=1e-12)
    assert abs(end[3:] @ b[3:]) == pytest.approx(1)


def test_moved_scenes(tmp_path):
    motion = sf.Motion([0, 1], [HERE, (1, 0, 0)])
    scene = sf.Scene([sf.Sphere(center=HERE, radius=1, name="ball", motion=motion), *scenes.boxes(1)])
    moved = scene.moved("ball", (1, 2, 3))
    assert moved["ball"].center == (1, 2, 3)
    assert moved["ball"].motion is None
    assert moved["box_1"] == scene["box_1"] if "box_1" in scene.names else moved["box_0"] == scene["box_0"]
    json.dumps(moved.to_json())
