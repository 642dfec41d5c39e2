"""The same file in every package: what differs stands in package.xml, and a file X_node.py with main() is the executable X."""

from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

manifest = ElementTree.parse("package.xml").getroot()
name = manifest.findtext("name")
folders = [folder for folder in ("launch", "config") if Path(folder).is_dir()]
setup(
    name=name,
    version=manifest.findtext("version"),
    description=manifest.findtext("description"),
    license=manifest.findtext("license"),
    maintainer=manifest.findtext("maintainer"),
    maintainer_email=manifest.find("maintainer").get("email"),
    packages=find_packages(include=[f"{name}*", "hidden_*"]),
    package_data={"": [f"**/*.{suffix}" for suffix in ("yaml", "json", "onnx", "npz", "md")]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
        *((f"share/{name}/{folder}", [str(file) for file in Path(folder).iterdir()]) for folder in folders),
    ],
    zip_safe=False,
    entry_points={"console_scripts": [f"{node.stem[:-5]} = {name}.{node.stem}:main" for node in Path(name).glob("*_node.py")]},
)
