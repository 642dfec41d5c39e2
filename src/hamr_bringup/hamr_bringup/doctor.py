"""What this machine lacks for HAMR, and how to get it. It starts with the standard library alone, so it works where little else does."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from importlib import metadata, util
from pathlib import Path
from random import randrange

PYTHONS = ((3, 11), (3, 12), (3, 13))
INSTALL = "make test in the checkout installs everything; by hand: pip install -e '.[ros]' -c constraints.txt"
LEAST_CORES = 2
PATIENCE = 20.0  # s
PIN = re.compile(r"""^([\w.-]+)==([\w.+-]+)(?:\s*;\s*extra == ["'](\w+)["'])?$""")


def rows() -> list[dict]:
    """One row a check: name, ok, value, advice. What is a convenience only is ok even when absent; its advice says what stands in."""
    return [
        _python(),
        *_packages(),
        _one_ros(),
        _round_trip(),
        _tool("ros2", "without it, hamr run and hamr up do its part"),
        _tool("colcon", "needed for make ros only; " + INSTALL),
        _kernels(),
        _encoder(),
        _cores(),
    ]


def _row(name: str, ok: bool, value: object, advice: str = "") -> dict:
    return {"name": name, "ok": ok, "value": str(value), "advice": advice}


def _python() -> dict:
    known = sys.version_info[:2] in PYTHONS
    return _row("Python", known, sys.version.split()[0], "" if known else "use Python 3.11, 3.12 or 3.13")


def _packages() -> list[dict]:
    """Installed against pinned versions; ROS from pip counts only where no other rclpy is."""
    try:
        pins = [match.groups() for match in map(PIN.match, metadata.requires("hamr") or []) if match]
    except metadata.PackageNotFoundError:
        return [_row("hamr", False, "not installed with pip, so the pinned versions are unknown", INSTALL)]
    system_ros = _rclpy() is not None and not _wheels()
    return [_package(name, pin) for name, pin, extra in pins if not extra or (extra == "ros" and not system_ros)]


def _package(name: str, pin: str) -> dict:
    try:
        found = metadata.version(name)
    except metadata.PackageNotFoundError:
        return _row(name, False, f"missing, {pin} is needed", INSTALL)
    same = found.split("+")[0] == pin
    return _row(name, same, found if same else f"{found}, tried with {pin}", "" if same else INSTALL)


def _rclpy() -> Path | None:
    spec = util.find_spec("rclpy")
    return Path(spec.origin) if spec and spec.origin else None


def _wheels() -> bool:
    """Whether ROS from pip is in this environment."""
    return any(Path(sys.prefix).glob("lib/python*/site-packages/ros_rclpy.libs"))


def _one_ros() -> dict:
    """A sourced ROS 2 and ROS from pip load each other's libraries."""
    sourced = os.environ.get("ROS_DISTRO")
    place = _rclpy()
    if place is None:
        return _row("rclpy", False, "missing", f"source an installed ROS 2 Jazzy, or {INSTALL}")
    mixed = bool(sourced and _wheels())
    if mixed:
        advice = "use a shell that has not sourced ROS, or an environment without the extra `ros`"
        return _row("rclpy", False, f"from pip, mixed with the sourced {sourced}", advice)
    return _row("rclpy", True, "from pip" if _wheels() else f"{sourced or 'installed'}, {place.parent}")


def _round_trip() -> dict:
    """A question and an answer between two processes, as nodes do: library, middleware, discovery and transport at once."""
    name, command = "ROS between processes", [sys.executable, "-m", f"{__package__}.roundtrip"]
    environment = {**os.environ, "ROS_DOMAIN_ID": str(randrange(1, 102))}
    answer = subprocess.Popen([*command, "answer"], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        ask = subprocess.run([*command, "ask"], env=environment, capture_output=True, text=True, timeout=PATIENCE, check=False)
    except subprocess.TimeoutExpired:
        return _row(name, False, "no answer", "the machine is too busy or blocks multicast on the loopback interface")
    finally:
        answer.kill()
        answer.wait()
    if ask.returncode == 0:
        middleware, seconds = ask.stdout.split()
        return _row(name, True, f"{middleware}, first answer after {seconds} s")
    if ask.stdout:
        return _row(name, False, "no answer", "allow UDP multicast on the loopback interface (ip link set lo multicast on)")
    return _row(name, False, ask.stderr.strip().splitlines()[-1] if ask.stderr.strip() else "it does not start", INSTALL)


def _tool(name: str, advice: str) -> dict:
    found = shutil.which(name) or shutil.which(name, path=str(Path(sys.executable).parent))
    return _row(name, True, found or "absent", "" if found else advice)


def _kernels() -> dict:
    """Where compiled kernels are kept between starts; a temporary folder does, but is lost at the next boot."""
    try:
        from hamr_dynamics.kernels import cache_folder

        folder = cache_folder()
    except (ImportError, OSError) as error:
        return _row("kernel cache", False, error, INSTALL)
    temporary = folder.is_relative_to(tempfile.gettempdir())
    return _row("kernel cache", True, folder, "set HAMR_CACHE to a folder that stays, to compile only once" if temporary else "")


def _encoder() -> dict:
    try:
        import imageio_ffmpeg

        return _row("video encoder", True, Path(imageio_ffmpeg.get_ffmpeg_exe()).name)
    except (ImportError, RuntimeError) as error:
        return _row("video encoder", False, error, INSTALL)


def _cores() -> dict:
    cores = len(os.sched_getaffinity(0))
    enough = cores >= LEAST_CORES
    return _row("cores", True, cores, "" if enough else f"with fewer than {LEAST_CORES} the nodes share one and real time may be missed")
