"""Attempts to reach outside: leftover processes, files, network, environment, and sabotage.

Attempts are not punished: right answers keep their points, and the attempts fail.
"""

from hostile.case import ALL, COUNTED, SANDBOXED, Case


def tries(name, code, tiers=SANDBOXED, **more):
    """A case with right answers; a cell at the end attempts something."""
    return Case(name, after=code, tiers=tiers, **more)


EACH_TRY = """
def attempt(what, *args, **kwargs):
    try:
        return what(*args, **kwargs)
    except BaseException as error:
        return error
"""

LEFTOVERS = [
    tries(
        "a daemon thread",
        "import threading, time\n"
        "threading.Thread(target=time.sleep, args=(9999,), daemon=True).start()",
        COUNTED,
    ),
    tries(
        "fifty children",
        """
import os, time
for _ in range(50):
    if os.fork() == 0:
        time.sleep(9999)
        os._exit(0)
""",
        COUNTED,
    ),
    tries(
        "a daemon: fork, setsid, fork",
        """
import os, time
if os.fork() == 0:
    os.setsid()
    if os.fork() == 0:
        time.sleep(9999)
    os._exit(0)
""",
        COUNTED,
    ),
    tries(
        "a program in the background",
        """
import subprocess
subprocess.Popen(["sleep", "9999@MARK@"], start_new_session=True)
""",
        COUNTED,
    ),
    tries(
        "a program that outlives its parent",
        """
import os
os.system("nohup setsid sleep 9999@MARK@ >/dev/null 2>&1 &")
""",
        COUNTED,
    ),
    tries(
        "a pool of processes",
        """
import multiprocessing
multiprocessing.Pool(2).map(abs, range(3))
""",
        SANDBOXED,
    ),
    tries(
        "a child in the middle of a call",
        "",
        SANDBOXED,
        lost=("01.2",),
        answers={
            "fit": """
def fit(points, values):
    import os, time
    if os.fork() == 0:
        time.sleep(9999)
    os._exit(1)
"""
        },
    ),
]

FILES = [
    tries(
        "files outside written, changed and deleted",
        EACH_TRY
        + """
import os, shutil
for path in ("@CANARY@/new", "/tmp/@MARK@", "/var/tmp/@MARK@", "/dev/shm/@MARK@", "/@MARK@",
             os.path.expanduser("~root/@MARK@"), "@HOME@/@MARK@", "@ROOT@/@MARK@", "../@MARK@x/y"):
    attempt(lambda: open(path, "w").write("hostile"))
for path in ("@CANARY@/secret", "@OUT@/results.json", "/etc/hosts"):
    for mode in ("a", "r+", "w"):
        attempt(lambda: open(path, mode).write("hostile"))
    attempt(os.truncate, path, 0)
    attempt(os.chmod, path, 0o777)
    attempt(os.chown, path, 1, 1)
    attempt(os.utime, path, (1, 1))
    attempt(os.rename, path, path + "x")
    attempt(os.link, path, "linked")
    attempt(os.open, path, os.O_RDONLY | os.O_TRUNC)
    attempt(os.setxattr, path, "user.hostile", b"x")
    attempt(os.unlink, path)
attempt(shutil.rmtree, "@CANARY@")
attempt(os.mkdir, "@CANARY@/folder")
attempt(os.symlink, "/etc/passwd", "@CANARY@/link")
attempt(os.mkfifo, "@CANARY@/pipe")
""",
    ),
    tries(
        "files outside written through links",
        EACH_TRY
        + """
import os
attempt(os.symlink, "@CANARY@", "way")
attempt(os.symlink, "@CANARY@/secret", "file")
attempt(lambda: open("way/new", "w").write("hostile"))
attempt(lambda: open("way/secret", "w").write("hostile"))
attempt(lambda: open("file", "w").write("hostile"))
attempt(os.rename, ".", "@CANARY@/home")
""",
    ),
    tries(
        "a secret file told in an error",
        "",
        answers={
            "fit": """
def fit(points, values):
    raise ValueError(open("@CANARY@/secret").read())
"""
        },
        lost=("01.2",),
    ),
    tries(
        "attributes of files that may only be read",
        """
import fcntl, fieldcheck, struct
file = open(fieldcheck.__file__, "rb")
changed = []
for name, get, put, size in (("flags", 0x80086601, 0x40086602, 8),
                             ("version", 0x80087601, 0x40087602, 8),
                             ("project", 0x801C581F, 0x401C5820, 28)):
    before = bytearray(size)
    try:
        fcntl.ioctl(file, get, before)
        fcntl.ioctl(file, put, bytes([before[0] ^ 0x40, *before[1:]]))
        changed.append(name)
    except OSError:
        pass
raise ValueError(f"changed: {changed}")
""",
        notes="changed: []",
    ),
    tries(
        "files of the system told in an error",
        """
told = ""
for path in ("/etc/shadow", "/etc/passwd", "@HOME@/.profile", "/boot/config"):
    try:
        told += open(path).read()
    except OSError:
        pass
raise ValueError("leaked " + told if told else "nothing to read")
""",
        notes="nothing to read",
    ),
]

NETWORK = [
    tries(
        "TCP",
        EACH_TRY
        + """
import socket
attempt(lambda: socket.create_connection(("127.0.0.1", @TCP@), 1).sendall(b"hostile"))
attempt(lambda: socket.create_connection(("8.8.8.8", 53), 1).sendall(b"hostile"))
""",
    ),
    tries(
        "UDP",
        EACH_TRY
        + """
import socket
attempt(lambda: socket.socket(socket.AF_INET, socket.SOCK_DGRAM).sendto(b"x", ("127.0.0.1", @UDP@)))
attempt(socket.getaddrinfo, "example.org", 80)
""",
    ),
    tries(
        "sockets of this machine",
        EACH_TRY
        + """
import socket
for address in ("@UNIX@", "\\0@MARK@"):
    for kind in (socket.SOCK_STREAM, socket.SOCK_DGRAM):
        attempt(lambda: socket.socket(socket.AF_UNIX, kind).connect(address))
        attempt(lambda: socket.socket(socket.AF_UNIX, kind).sendto(b"x", address))
""",
    ),
    tries(
        "a page fetched",
        EACH_TRY
        + """
import urllib.request
attempt(urllib.request.urlopen, "http://127.0.0.1:@TCP@/", timeout=1)
attempt(np.load, "http://127.0.0.1:@TCP@/")
""",
    ),
    tries(
        "a port opened",
        """
import socket
try:
    server = socket.socket()
    server.bind(("0.0.0.0", 0))
    server.listen()
    opened = True
except OSError:
    opened = False
assert not opened, "a port is open"
raise ValueError("no port")
""",
        notes="no port",
    ),
]

ENVIRONMENT = [
    tries(
        "secrets of the environment",
        """
import os
raise ValueError(repr(dict(os.environ)))
""",
        ALL,
        notes="ValueError",
    ),
    tries(
        "secrets of the grader's environment",
        """
import glob, os
told = ""
for path in ("/proc/self/environ", f"/proc/{os.getppid()}/environ", "/proc/@GRADER@/environ",
             "/proc/@GRADER@/cmdline", *glob.glob("/proc/[0-9]*/environ")):
    try:
        told += open(path, "rb").read().decode("latin-1")
    except OSError:
        pass
import re
raise ValueError(str(re.findall("GRADER_SECRET=[a-z0-9]+", told)))
""",
        notes="ValueError",
    ),
    tries(
        "the grader's memory",
        EACH_TRY
        + """
import ctypes, os
for process in (os.getppid(), @GRADER@):
    for name in ("mem", "maps", "fd", "cwd", "root"):
        found = attempt(lambda: open(f"/proc/{process}/{name}", "rb").read(1))
        assert isinstance(found, OSError), name
    assert ctypes.CDLL(None).ptrace(16, process, 0, 0) == -1
raise ValueError("nothing to see")
""",
        notes="nothing to see",
    ),
]

POISON = [
    tries(
        "start-up files",
        EACH_TRY
        + """
import os, site, sys
code = "import numpy; numpy.linalg.solve = None; open('@CANARY@/poisoned', 'w')"
places = [*sys.path, os.path.expanduser("~"), os.environ["HOME"], "@HOME@", "@HOME@/.ipython/"
          "profile_default/startup", site.getusersitepackages(), ".", ".."]
for place in places:
    attempt(os.makedirs, place, exist_ok=True)
    for name in ("sitecustomize.py", "usercustomize.py", "numpy.py", "00.py", "conftest.py",
                 ".pythonrc", "poison.pth", "json.py"):
        attempt(lambda: open(os.path.join(place, name), "a").write(code))
""",
    ),
    tries(
        "compiled files",
        EACH_TRY
        + """
import glob, os, sys, importlib.util
for module in list(sys.modules.values()):
    path = getattr(module, "__cached__", None) or getattr(module, "__file__", None)
    if path:
        attempt(lambda: open(path, "ab").write(b"x"))
        attempt(os.unlink, path)
""",
    ),
    tries(
        "matplotlib's settings and fonts",
        EACH_TRY
        + """
import glob, os, matplotlib
from matplotlib import font_manager
places = [matplotlib.get_configdir(), matplotlib.get_cachedir()]
places += [os.path.dirname(font_manager.__file__)]
places += [*glob.glob(os.environ["HOME"] + "/../*"), *glob.glob(os.environ["HOME"] + "/../../*")]
for place in places:
    for name in ["matplotlibrc", *map(os.path.basename, glob.glob(place + "/font*"))]:
        attempt(lambda: open(os.path.join(place, name), "w").write("backend: hostile"))
""",
    ),
    tries(
        "modules patched",
        """
import json, os, sys, random
np.linalg.solve = np.hstack = np.ones = lambda *args, **kwargs: None
json.dumps = json.loads = os.write = os.read = lambda *args: 1 / 0
sys.path[:] = []
""",
        ALL,
        status="partly",
        # they call what the first line has replaced; 01.3 and 01.6, which call 01.1, do not lose
        lost=("01.1", "01.2"),
    ),
    tries(
        "files for the next in every folder that can be written",
        EACH_TRY
        + """
import os
home = os.path.abspath(".")
for place in (home, os.path.dirname(home), os.path.dirname(os.path.dirname(home))):
    for name in ("numpy.py", "answers.txt", ".progress.json", "sitecustomize.py"):
        attempt(lambda: open(os.path.join(place, name), "w").write("raise SystemExit"))
attempt(os.rename, home, home + "x")
""",
    ),
    tries(
        "the server and the grader signalled",
        EACH_TRY
        + """
import os, signal
for process in (os.getppid(), @GRADER@, -1, 0, -os.getppid()):
    for number in (signal.SIGSTOP, signal.SIGKILL, signal.SIGTERM, signal.SIGINT):
        attempt(os.kill, process, number)
        attempt(os.killpg, process, number)
        attempt(lambda: signal.pidfd_send_signal(os.pidfd_open(process), number))
""",
    ),
    tries(
        "the server's limits lowered",
        EACH_TRY
        + """
import os, resource
for process in (os.getppid(), @GRADER@):
    for name in ("AS", "CPU", "NOFILE", "FSIZE"):
        attempt(resource.prlimit, process, getattr(resource, "RLIMIT_" + name), (0, 0))
    attempt(os.setpriority, os.PRIO_PROCESS, process, 19)
    attempt(os.sched_setaffinity, process, {0})
""",
    ),
    tries(
        "rights regained",
        EACH_TRY
        + """
import ctypes, os
libc = ctypes.CDLL(None, use_errno=True)
attempt(os.setuid, 0); attempt(os.setgid, 0); attempt(os.setgroups, [0])
for flags in (0x10000000, 0x20000, 0x40000000, 0x7E020000):
    assert libc.unshare(flags) == -1
assert libc.mount(b"none", b"/", b"tmpfs", 0, None) == -1
assert libc.chroot(b"/") == -1
assert libc.prctl(1, 0, 0, 0, 0) == -1
assert libc.shmget(1, 4096, 0o1600) == -1
raise ValueError("none regained")
""",
        notes="none regained",
    ),
]

CASES = [*LEFTOVERS, *FILES, *NETWORK, *ENVIRONMENT, *POISON]
