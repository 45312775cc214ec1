"""Installs microgripper_control, by pip and as a ROS 2 package (ament_python) by colcon."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "microgripper_control"

# Each dependency has its line in package.xml too. The lower bounds are what Ubuntu 24.04, the home
# of ROS 2 Jazzy, ships; its messages are compiled against numpy 1 and must not meet numpy 2 there.
DEPENDENCIES = [
    "control>=0.10,<0.11",  # transfer functions, margins and discretisation for the paper
    "joblib>=1.3,<2",  # tries candidates in parallel
    "matplotlib>=3.6,<4",  # every figure
    "numba>=0.59,<1",  # compiles the hot loops
    "numpy>=1.26,<3",  # arrays
    "rich>=13.7,<16",  # tables and progress bars
    "rosbags>=0.11,<0.12",  # reads and writes rosbag2 with no ROS installed
    "scipy>=1.11,<2",  # optimisers, filters, independent integrators in the tests
    "typer>=0.9,<1",  # the command line
    "PyYAML>=6.0,<7",  # model files and parameters
]

# ROS 2 Jazzy as wheels, for a machine without it.
ROS = [
    "ros-jazzy-diagnostic-msgs==5.3.6",  # /diagnostics
    "ros-jazzy-lifecycle-msgs==2.0.3",  # states of managed nodes
    "ros-jazzy-rcl-interfaces==2.0.3",  # ranges and descriptions of parameters
    "ros-jazzy-rclpy==7.1.6",  # nodes
    "ros-jazzy-rmw-fastrtps-cpp==8.4.3",  # DDS
    "ros-jazzy-rosgraph-msgs==2.0.3",  # /clock
    "ros-jazzy-sensor-msgs==5.3.6",  # joint_states
    "ros-jazzy-std-msgs==5.3.6",  # setpoint, voltage_command, displacement
    "ros-jazzy-std-srvs==5.3.6",  # services without arguments
]

# A Dask cluster for `--scheduler`.
CLUSTER = ["distributed>=2024.1,<2027"]  # brings dask

TEST = [
    *CLUSTER,  # a scheduler and workers on this machine
    "hypothesis>=6.100,<7",  # properties on drawn inputs
    "mypy>=2.4,<2.5",  # types
    "pytest>=9,<10",  # runs the tests
    "pytest-xdist>=3.8,<4",  # one on each core
    "ruff>=0.17.5,<0.18",  # style; a later one formats otherwise
    "types-PyYAML>=6.0.12,<6.1",  # types of PyYAML
]

CONFIG = {
    str(folder): [str(file) for file in sorted(folder.iterdir()) if file.is_file()]
    for folder in map(Path, ("config", "config/sros2", "config/sros2/common"))
}
LAUNCH = [str(path) for path in sorted(Path("launch").glob("*.launch.py"))]
NODES = [
    "plant_simulator",
    "controller",
    "reference",
    "identifier",
    "diagnoser",
    "recorder",
    "player",
]

setup(
    name=NAME,
    version="0.1.0",
    description="Simulate, control, identify and diagnose a piezo microgripper",
    author="microgripper_control authors",
    license="Apache-2.0",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed", "bench/rivals/*.c", "report/assets/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *((f"share/{NAME}/{folder}", files) for folder, files in CONFIG.items()),
        (f"share/{NAME}/launch", LAUNCH),
    ],
    python_requires=">=3.10",
    install_requires=DEPENDENCIES,
    extras_require={"ros": ROS, "cluster": CLUSTER, "test": TEST},
    entry_points={
        "console_scripts": [
            f"microgripper = {NAME}.cli.main:main",
            *(f"{node} = {NAME}.nodes.{node}:main" for node in NODES),
        ]
    },
    zip_safe=False,
)
