# SPDX-License-Identifier: Apache-2.0
"""Starting, refusing to start, and what is left behind."""
import os
import shutil
import signal
import socket
import subprocess
import unittest

from harness import FLARED, LENS, PATIENCE_S, SOURCE, Daemon, Scenario


def run_flared(*arguments):
    return subprocess.run([FLARED, *arguments], capture_output=True, text=True,
                          timeout=PATIENCE_S, check=False)


class StartupScenario(Scenario):
    def test_bad_usage_ends_with_2_and_says_where(self):
        rows = [
            (["--nonsense"], "nonsense"),
            (["--workers", "many"], "many"),
            (["--workers", "-1"], "workers"),
            (["--listen", "gopher://x"], "gopher"),
            (["--listen", "http://0.0.0.0:0"], "allow_remote"),
            (["--listen", "unix:/" + "x" * 200], "107"),
            (["--log-level", "loud"], "log_level"),
            (["--lenses", self.path("none")], "none"),
            (["--config", self.path("none.toml")], "none.toml"),
            (["--config", self.write("a.toml", "workers = 1\nworkerz = 2\n")], "line 2, column 1"),
            (["--config", self.write("b.toml", "queue = 0\n")], "line 1"),
            (["--config", self.write("c.toml", "queue = \n")], "line 1"),
        ]
        for arguments, word in rows:
            done = run_flared(*arguments)
            self.assertEqual(done.returncode, 2, f"{arguments}: {done.stderr}")
            self.assertIn(word, done.stderr, arguments)
            self.assertEqual(done.stdout.count("listening"), 0, arguments)

    def test_help_and_version_end_with_0(self):
        self.assertIn("--cache-mb", run_flared("--help").stdout)
        self.assertRegex(run_flared("--version").stdout, r"^flared \d+\.\d+\.\d+\n$")

    def test_a_config_file_is_obeyed_and_the_command_line_wins(self):
        config = self.write("flared.toml", 'cache_mb = 3\nsocket_mode = "0660"\nqueue = 7\n')
        with Daemon("--config", config, "--queue", "8") as daemon:
            self.assertEqual(os.stat(daemon.socket_path).st_mode & 0o777, 0o660)
            self.assert_ok(daemon.get("/healthz"))

    def test_a_port_of_its_own_choice_is_printed_and_served(self):
        with Daemon() as daemon:
            self.assertNotEqual(daemon.tcp_address()[1], 0)
            self.assert_ok(daemon.get("/healthz", tcp=True))

    def test_two_daemons_do_not_share_a_socket(self):
        with Daemon() as daemon:
            done = run_flared("--listen", "unix:" + daemon.socket_path)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn("another program listens", done.stderr)
            self.assert_ok(daemon.get("/healthz"))

    def test_a_socket_left_by_a_crash_is_replaced(self):
        first = Daemon(folder=self.folder)
        first.process.kill()
        first.process.wait()
        first.process.stdout.close()
        self.assertTrue(os.path.exists(first.socket_path))
        with Daemon(folder=self.folder) as second:
            self.assert_ok(second.get("/healthz"))
        self.assertFalse(os.path.exists(first.socket_path), "removed at an orderly end")

    def test_a_file_in_the_way_is_left_alone(self):
        path = self.write("precious", "precious")
        done = run_flared("--listen", "unix:" + path)
        self.assertEqual(done.returncode, 1)
        with open(path, encoding="utf-8") as file:
            self.assertEqual(file.read(), "precious")

    def test_sigint_and_sigterm_end_with_0(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with Daemon() as daemon:
                idle = daemon.raw()
                daemon.process.send_signal(number)
                self.assertEqual(daemon.process.wait(PATIENCE_S), 0)
                self.assertFalse(os.path.exists(daemon.socket_path))
                idle.close()

    def test_broken_lens_files_are_listed_and_the_rest_served(self):
        with Daemon() as daemon:
            names = [lens["name"] for lens in daemon.get("/v1/lenses").json()["lenses"]]
        self.assertIn(LENS, names)
        source = os.path.join(SOURCE, "lenses")
        lenses = self.path("lenses")
        shutil.copytree(source, lenses)
        self.write("lenses/broken-syntax.toml", "name = \n")
        self.write("lenses/broken-lens.toml", 'name = "broken-lens"\n[[surface]]\nkind = "blob"\n')
        with Daemon("--lenses", lenses) as daemon:
            listed = daemon.get("/v1/lenses").json()
            self.assertEqual([lens["name"] for lens in listed["lenses"]], names)
            broken = {entry["name"]: entry["error"] for entry in listed["broken"]}
            self.assertEqual(set(broken), {"broken-syntax", "broken-lens"})
            self.assertIn("line 1", broken["broken-syntax"]["where"])
            self.assertIn("line 3", broken["broken-lens"]["where"])
            reply = daemon.get("/v1/lenses/broken-lens")
            self.assertEqual(reply.status, 400)
            self.assertEqual(reply.error["code"], broken["broken-lens"]["code"])

    def test_a_peer_that_vanishes_while_it_is_answered_does_no_harm(self):
        with Daemon() as daemon:
            for _ in range(50):
                connection = daemon.raw()
                connection.sendall(b"GET /v1/openapi.yaml HTTP/1.1\r\nHost: x\r\n\r\n")
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER,
                                      b"\x01\0\0\0\0\0\0\0")  # close means reset
                connection.close()
            self.assert_ok(daemon.get("/healthz"))


if __name__ == "__main__":
    unittest.main()
