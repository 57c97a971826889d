#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""embed runs to its end, and stops cleanly when a signal comes while both threads are swimming.

test_embed.py PROGRAM"""
import re
import signal
import subprocess
import sys
import time

LINE = re.compile(r"^\[ *\d+\.\d{3}\] (program|error|warning|info|debug) +(.*)$")


def check(condition, text, output):
    if not condition:
        sys.exit(f"{text}\n{output}")


def messages(output, who):
    """Texts of one voice; every line of the program has the logger's form."""
    found = [LINE.match(line) for line in output.splitlines()]
    check(all(found), "a line did not go through the logger", output)
    return [match.group(2) for match in found if match.group(1) == who]


def to_the_end(program):
    done = subprocess.run([program, "12"], capture_output=True, text=True, timeout=300, check=False)
    check(done.returncode == 0 and not done.stderr, f"exit code {done.returncode}: {done.stderr}", done.stdout)
    designs = [text for text in messages(done.stdout, "info") if text.startswith("design set: ")]
    check(len(designs) == 2, "expected the library's message about each of two designs", done.stdout)
    said = messages(done.stdout, "program")
    for name in ("stout", "between"):
        check(f"{name}: DQA_SUCCESS after 12 of 12 steps" in said, f"{name} did not finish", done.stdout)
    check(said[-1] == "finished", "wrong last line", done.stdout)


def interrupted(program, number):
    process = subprocess.Popen([program, "1000000"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    lines, swimming = [], set()
    try:
        while swimming != {"stout", "between"}:
            line = process.stdout.readline()
            check(line, "the program ended by itself", "".join(lines))
            lines.append(line)
            swimming.update(re.findall(r"program +(\w+): \d+ steps, head", line))
        process.send_signal(number)
        sent = time.monotonic()
        rest, errors = process.communicate(timeout=120)
    finally:
        process.kill()
    output = "".join(lines) + rest
    check(process.returncode == 0 and not errors, f"exit code {process.returncode}: {errors}", output)
    said = messages(output, "program")
    for name in ("stout", "between"):
        check(any(re.fullmatch(rf"{name}: DQA_CANCELLED after \d+ of 1000000 steps: .*", text) for text in said),
              f"{name} was not cancelled", output)
    check(said[-1] == "stopped by a signal", "wrong last line", output)
    print(f"{number.name}: stopped after {time.monotonic() - sent:.2f} s")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: test_embed.py PROGRAM")
    bad = subprocess.run([sys.argv[1], "none"], capture_output=True, text=True, timeout=60, check=False)
    check(bad.returncode == 2 and "usage" in bad.stderr, "a bad argument was accepted", bad.stdout)
    to_the_end(sys.argv[1])
    for number in (signal.SIGINT, signal.SIGTERM):
        interrupted(sys.argv[1], number)
