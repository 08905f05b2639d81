"""Measures how the studio keeps up: studio_bars.py PROGRAM SCENE [--minutes M] [-- OPTIONS OF THE STUDIO...]

Starts `fascicle studio SCENE` twice, the second time with everything cached, plays the clip, then changes a key
repeatedly. Measures from each command to the first frame computed with the change. First it checks that such a frame
arrives and has a different hash. Prints Markdown."""

import argparse
import base64
import json
import os
import re
import socket
import statistics
import struct
import subprocess
import sys
import tempfile
import time

PATIENCE = 300.0  # s
TEXT, BINARY, PING, PONG = 1, 2, 9, 10


class Page:
    """A page as the server sees it: one WebSocket (RFC 6455)."""

    def __init__(self, address):
        host, port, token = re.match(r"http://([\d.]+):(\d+)/#([0-9a-f]+)", address).groups()
        self.socket = socket.create_connection((host, int(port)))
        self.socket.settimeout(PATIENCE)
        self.bytes = b""
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(("GET /live?token=%s HTTP/1.1\r\nHost: %s:%s\r\nOrigin: http://%s:%s\r\n"
                             "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: %s\r\n"
                             "Sec-WebSocket-Version: 13\r\n\r\n" % (token, host, port, host, port, key)).encode())
        while b"\r\n\r\n" not in self.bytes:
            self.more()
        head, _, self.bytes = self.bytes.partition(b"\r\n\r\n")
        if b" 101 " not in head.splitlines()[0]:
            sys.exit("studio_bars: the studio answers " + head.splitlines()[0].decode())

    def more(self):
        got = self.socket.recv(1 << 20)
        if not got:
            sys.exit("studio_bars: the studio has ended")
        self.bytes += got

    def take(self, count):
        while len(self.bytes) < count:
            self.more()
        taken, self.bytes = self.bytes[:count], self.bytes[count:]
        return taken

    def next(self):
        """A text message as parsed JSON, or a binary message as bytes."""
        content, kind = b"", 0
        while True:
            first, length = self.take(2)
            if length == 126:
                (length,) = struct.unpack(">H", self.take(2))
            elif length == 127:
                (length,) = struct.unpack(">Q", self.take(8))
            part = self.take(length)
            if first & 15 == PING:
                self.socket.sendall(struct.pack(">BB", 128 | PONG, 128 | len(part)) + b"\0\0\0\0" + part)
            if first & 15 > BINARY:
                continue
            kind = first & 15 or kind
            content += part
            if first & 128:
                return json.loads(content) if kind == TEXT else content

    def send(self, kind, **members):
        text = json.dumps({"type": kind, "id": 1, **members}).encode()
        size = struct.pack(">BB", 129, 128 | len(text)) if len(text) < 126 else \
            struct.pack(">BBH", 129, 128 | 126, len(text))
        self.socket.sendall(size + b"\0\0\0\0" + text)  # a mask of zeros

    def until(self, wanted):
        """The first message for which `wanted` is true."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            message = self.next()
            if isinstance(message, dict) and message.get("type") in ("refused", "failed"):
                sys.exit("studio_bars: %s" % message)
            if wanted(message):
                return message
        sys.exit("studio_bars: what was waited for did not come in %d s" % PATIENCE)


def is_frame(message):
    return isinstance(message, bytes) and message[0] == 1


def revision_of(frame):
    return struct.unpack_from("<I", frame, 12)[0]


def hash_of(frame):
    return struct.unpack_from("<Q", frame, 32)[0]


def started(asked, folder):
    """(the program, its page, seconds until the first frame)"""
    begin = time.monotonic()
    command = [asked.program, "studio", asked.scene, "--headless", "-o", folder, *asked.options]
    program = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    for line in program.stdout:
        found = re.search(r"http://127\.0\.0\.1:\d+/#[0-9a-f]+", line)
        if found:
            page = Page(found.group())
            page.until(is_frame)
            return program, page, time.monotonic() - begin
    sys.exit("studio_bars: the studio ended at its start")


def memory_of(program):
    with open("/proc/%d/status" % program.pid) as file:
        return int(re.search(r"VmRSS:\s+(\d+)", file.read()).group(1)) / 1024


def frames_a_second(page, seconds):
    """(frames that reached the page, frames that the solver could compute) per second."""
    end, count, rates = time.monotonic() + seconds, 0, []
    while time.monotonic() < end:
        frame = page.until(is_frame)
        count += 1
        rates.append(struct.unpack_from("<f", frame, 44)[0])
    return count / seconds, statistics.median(rates)


def seconds_of(page, kind, **members):
    """From the command to the first frame computed with it."""
    begin = time.monotonic()
    page.send(kind, **members)
    applied = page.until(lambda message: isinstance(message, dict) and message.get("type") == "applied")
    page.until(lambda message: is_frame(message) and revision_of(message) >= applied["revision"])
    return time.monotonic() - begin


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("scene")
    parser.add_argument("--minutes", type=float, default=0.0, help="minutes of looping, to see whether memory grows")
    parser.add_argument("options", nargs="*")
    asked = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        program, page, seconds = started(asked, os.path.join(folder, "first"))
        program.kill()
        program.wait()
        rows.append(("first start, to the first frame", "%.1f s" % seconds))
        program, page, seconds = started(asked, os.path.join(folder, "second"))
        try:
            rows.append(("second start", "%.1f s" % seconds))
            before = hash_of(page.until(is_frame))
            seconds_of(page, "set", changes={"flesh.softness": 3.0})
            if hash_of(page.until(is_frame)) == before:
                sys.exit("studio_bars: a change of the softness is in no frame")
            frames, rate = frames_a_second(page, 20.0)
            rows.append(("frames a second at the page, at the clip's pace", "%.0f" % frames))
            rows.append(("frames a second of the solver", "%.0f" % rate))
            for what, key, values in (
                    ("softness", "flesh.softness", (1.2, 1.5, 1.1, 1.3, 1.25)),
                    ("exaggeration", "flesh.exaggerate", (1.2, 1.5, 1.1, 1.3, 1.25)),
                    ("gravity", "scene.gravity", ([0, -5, 0], [0, -3, 0], [0, -9, 0], [0, -6, 0], [0, -7, 0])),
                    ("beta of a layer", "layers.fat.beta", (0.5, 0.2, 0.7, 0.3, 0.6))):
                found = []
                for value in values:
                    found.append(seconds_of(page, "set", changes={key: value}))
                    time.sleep(0.2)
                rows.append(("change of %s: median, worst" % what,
                             "%.0f ms, %.0f ms" % (1e3 * statistics.median(found), 1e3 * max(found))))
            rows.append(("undo", "%.0f ms" % (1e3 * seconds_of(page, "undo"))))
            if asked.minutes > 0:
                frames_a_second(page, 30.0)
                first = memory_of(program)
                frames_a_second(page, 60.0 * asked.minutes)
                rows.append(("memory before and after %g minutes of looping" % asked.minutes,
                             "%.0f MiB, %.0f MiB" % (first, memory_of(program))))
        finally:
            program.kill()
            program.wait()
    print("| %s | |\n| --- | --- |" % os.path.basename(asked.scene))
    for row in rows:
        print("| %s | %s |" % row)


if __name__ == "__main__":
    main()
