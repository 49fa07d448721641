# SPDX-License-Identifier: Apache-2.0
"""Starts a real flared in a folder of its own, talks to it, and stops it.

The programs come from the environment (ctest sets it): FLARED and FLARE, paths of the two binaries;
by hand, those of the release build are run.
Only Python's standard library is used. Times here are patience, not expectations: a loaded machine
may be slow, but nothing should hang for ever.
"""
import http.client
import json
import os
import re
import shutil
import signal
import socket
import struct
import subprocess
import tempfile
import threading
import time
import unittest

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FLARED = os.environ.get("FLARED", os.path.join(SOURCE, "build/release/bin/flared"))
FLARE = os.environ.get("FLARE", os.path.join(SOURCE, "build/release/bin/flare"))
LENS = "tronnier-double-gauss-50mm-f2"
PATIENCE_S = float(os.environ.get("FLARE_TEST_PATIENCE_S", "120"))


def small_request(**changes):
    """A request that is cheap to render: few pixels, coarse meshes."""
    request = {
        "lens": LENS,
        "f_number": 4.0,
        "image": {"width": 48, "height": 27, "sensor_width_mm": 36.0},
        "lights": [{"direction": [0.087, 0.05, 0.995], "irradiance": [1, 1, 1]}],
        "quality": {"preset": "draft"},
    }
    request.update(changes)
    return {key: value for key, value in request.items() if value is not None}


def slow_request(**changes):
    """A request that takes long enough for something to happen meanwhile: many lights."""
    lights = [{"direction": [0.001 * i, 0.05, 1.0], "irradiance": [1, 1, 1]} for i in range(400)]
    return small_request(lights=lights, **changes)


class UnixConnection(http.client.HTTPConnection):
    def __init__(self, path, timeout=PATIENCE_S):
        super().__init__("localhost", timeout=timeout)
        self.path = path

    def connect(self):
        self.sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.sock.settimeout(self.timeout)
        self.sock.connect(self.path)


class Reply:
    def __init__(self, response):
        self.status = response.status
        self.headers = response.headers
        self.body = response.read()

    def json(self):
        return json.loads(self.body)

    @property
    def error(self):
        return self.json()["error"]

    @property
    def report(self):
        return json.loads(self.headers["Flare-Report"])


def exr_attributes(body):
    """The header of a scan-line EXR: {name: value} of its strings and floats."""
    assert body[:4] == b"v/1\x01", body[:8]
    values, at = {}, 8
    while body[at]:
        name_end = body.index(b"\0", at)
        type_end = body.index(b"\0", name_end + 1)
        name, kind = body[at:name_end].decode(), body[name_end + 1:type_end]
        size = int.from_bytes(body[type_end + 1:type_end + 5], "little")
        at = type_end + 5 + size
        if kind == b"float":
            values[name] = struct.unpack("<f", body[at - size:at])[0]
        elif kind == b"string":
            values[name] = body[at - size:at].decode()
    return values


class Daemon:
    """A running flared on a Unix socket and on a TCP port of its own choice. It keeps meshes on disk
    only if its options name a folder."""

    def __init__(self, *options, folder=None, tcp=True):
        self.own_folder = folder is None
        self.folder = folder or tempfile.mkdtemp(prefix="flared-")
        self.socket_path = os.path.join(self.folder, "flared.sock")
        self.log_path = os.path.join(self.folder, "log")
        command = [FLARED, "--listen", "unix:" + self.socket_path]
        if tcp:
            command += ["--listen", "http://127.0.0.1:0"]
        if "--disk-cache" not in options:
            command += ["--disk-cache-mb", "0"]
        with open(self.log_path, "ab") as log:
            self.process = subprocess.Popen(
                command + list(options), stdout=subprocess.PIPE, stderr=log, text=True)
        self.urls = []
        for _ in range(2 if tcp else 1):
            line = self.process.stdout.readline()
            if not line.startswith("listening "):
                self.process.wait(PATIENCE_S)
                raise AssertionError("flared did not start: " + self.log())
            self.urls.append(line.split()[1])
        self.unix_url = self.urls[0]
        self.tcp_url = self.urls[1] if tcp else None

    def __enter__(self):
        return self

    def __exit__(self, kind, value, trace):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
            try:
                self.process.wait(PATIENCE_S)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
                raise AssertionError("flared did not stop: " + self.log())
        self.process.stdout.close()
        code = self.process.returncode
        log = self.log()
        if self.own_folder:
            shutil.rmtree(self.folder, ignore_errors=True)
        if kind is None and code != 0:
            raise AssertionError(f"flared ended with {code}: {log}")

    def log(self):
        with open(self.log_path, encoding="utf-8", errors="replace") as file:
            return file.read()[-4000:]

    def tcp_address(self):
        host, port = self.tcp_url.removeprefix("http://").rsplit(":", 1)
        return host, int(port)

    def raw(self):
        """A bare connection over TCP, for what no HTTP library would send."""
        return socket.create_connection(self.tcp_address(), timeout=PATIENCE_S)

    def ask(self, method, target, body=None, headers=None, tcp=False):
        if tcp:
            connection = http.client.HTTPConnection(*self.tcp_address(), timeout=PATIENCE_S)
        else:
            connection = UnixConnection(self.socket_path)
        try:
            connection.request(method, target, body=body, headers=headers or {})
            return Reply(connection.getresponse())
        finally:
            connection.close()

    def get(self, target, **keywords):
        return self.ask("GET", target, **keywords)

    def flare(self, request, accept=None, **keywords):
        body = request if isinstance(request, (str, bytes)) else json.dumps(request)
        headers = {"Content-Type": "application/json"}
        if accept:
            headers["Accept"] = accept
        return self.ask("POST", "/v1/flare", body=body, headers=headers, **keywords)

    def metrics(self):
        """{'name{labels}': value}, labels in alphabetical order."""
        values = {}
        for line in self.get("/metrics").body.decode().splitlines():
            if line.startswith("#") or not line.strip():
                continue
            name, value = line.rsplit(" ", 1)
            labels = re.findall(r'(\w+)="([^"]*)"', name)
            key = name.split("{")[0]
            if labels:
                key += "{" + ",".join(f"{k}={v}" for k, v in sorted(labels)) + "}"
            values[key] = float(value)
        return values

    def metric(self, name):
        return self.metrics().get(name, 0.0)


def eventually(condition, patience_s=PATIENCE_S):
    """Waits until the condition holds; says whether it ever did."""
    end = time.monotonic() + patience_s
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.02)
    return False


def at_once(count, work):
    """Runs work(0) ... work(count - 1) in threads that start together; their results in order."""
    results = [None] * count
    start = threading.Barrier(count)

    def run(index):
        start.wait()
        results[index] = work(index)

    threads = [threading.Thread(target=run, args=(i,)) for i in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return results


class Scenario(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="flare-scenario-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, content):
        with open(self.path(name), "wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())
        return self.path(name)

    def run_flare(self, *arguments, exit_code=0):
        done = subprocess.run([FLARE, *arguments], capture_output=True, text=True,
                              timeout=PATIENCE_S, check=False)
        self.assertEqual(done.returncode, exit_code, done.stderr)
        return done.stdout

    def assert_ok(self, reply):
        self.assertEqual(reply.status, 200, reply.body[:500])
        return reply

    def assert_refused(self, reply, status, code, where, name=""):
        self.assertEqual(reply.status, status, f"{name}: {reply.body[:300]}")
        self.assertEqual(reply.headers["Content-Type"], "application/json", name)
        error = reply.error
        self.assertEqual(set(error), {"code", "message", "where"}, name)
        self.assertEqual((error["code"], error["where"]), (code, where), f"{name}: {error}")
        self.assertTrue(error["message"], name)
