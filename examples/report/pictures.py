#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Pictures for papers and READMEs from a report: pictures.py REPORT FOLDER writes

  initial.png, optimised.png   each swimmer alone (by the names in the report)
  swimmers.png                 all of them, at three quarters of their way
  loss.png                     the first chart
  a-chart's-title.svg          every chart, as its own button saves it
  swimmers.webp                the motion, for as long as the swim takes, looping (--gif: swimmers.gif)

Needs Chromium, and for the motion img2webp (Debian: webp) or, with --gif, ImageMagick."""
import argparse
import os
import shutil
import subprocess
import sys
import tempfile

import browser

WIDE, HIGH = 720, 400  # of the motion, pixels


def save_view(page, path, selector, scale=1):
    with open(path, "wb") as stream:
        stream.write(page.screenshot(selector, scale=scale))
    print(path, os.path.getsize(path) // 1024, "KiB")


def save_charts(page, folder):
    """Presses the button of every chart and keeps what it would have saved."""
    page.evaluate("""window.saved = []; window.keep = URL.createObjectURL;
        URL.createObjectURL = (blob) => { saved.push(blob.text()); return "data:,"; };
        HTMLAnchorElement.prototype.click = function () { saved.push(this.download); };""")
    count = page.evaluate("document.querySelectorAll('.chart .save').forEach((b) => b.click()); saved.length / 2")
    for k in range(count):
        name = page.evaluate(f"saved[{2 * k + 1}]")
        with open(os.path.join(folder, name), "w", encoding="utf-8") as stream:
            stream.write(page.evaluate(f"saved[{2 * k}]"))
    print(f"{count} charts")


def save_motion(page, path, every):
    steps = page.evaluate("report.player.swimmers[0].times.length - 1")
    duration = page.evaluate("report.player.duration")
    with tempfile.TemporaryDirectory() as scratch:
        frames = []
        for k in range(0, steps, every):
            page.evaluate(f"report.player.time = {k * duration / steps}; report.player.draw()")
            frames.append(os.path.join(scratch, f"{k:04d}.png"))
            with open(frames[-1], "wb") as stream:
                stream.write(page.screenshot("#view"))
        delay = round(1000 * duration * every / steps)
        if path.endswith(".webp"):
            command = ["img2webp", "-loop", "0", "-lossy", "-q", "62", "-m", "6", "-d", str(delay), *frames, "-o", path]
        else:
            command = ["convert", "-delay", str(round(delay / 10)), "-loop", "0", *frames, "-colors", "96", "-layers",
                       "optimize", path]
        if shutil.which(command[0]) is None:
            sys.exit(f"pictures.py: {command[0]} is not installed, so there is no {path}")
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    print(path, os.path.getsize(path) // 1024, "KiB,", len(frames), "frames")


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("report")
    options.add_argument("folder")
    options.add_argument("--gif", action="store_true", help="swimmers.gif instead of swimmers.webp")
    options.add_argument("--dark", action="store_true", help="on a dark ground")
    options.add_argument("--colour", default="body", choices=("body", "actuation", "speed"))
    options.add_argument("--every", type=int, default=1, help="of the motion, only every N-th frame")
    o = options.parse_args()
    if browser.find() is None:
        sys.exit("pictures.py: Chromium is not installed")
    os.makedirs(o.folder, exist_ok=True)
    with browser.Browser(1280, 900) as page:
        page.media("dark" if o.dark else "light", motion="reduce")
        page.open(o.report)
        save_charts(page, o.folder)
        save_view(page, os.path.join(o.folder, "loss.png"), ".chart > svg", 3)
        page.evaluate(f"document.getElementById('view').style.cssText = 'width: {WIDE}px; height: {HIGH}px';"
                      "document.getElementById('scale').style.visibility = 'hidden'; new Promise(requestAnimationFrame)")
        page.resize(1280, 900, 3)
        page.evaluate(f"report.player.setMode('{o.colour}'); report.player.resize();"
                      "report.player.time = 0.75 * report.player.duration")
        for name in ["all", *page.evaluate("report.swimmers.map((s) => s.name)")]:
            page.evaluate(f"report.player.show({name!r}); report.player.draw()")
            save_view(page, os.path.join(o.folder, ("swimmers" if name == "all" else name) + ".png"), "#view")
        page.resize(1280, 900, 1)
        page.evaluate("report.player.show('all'); report.player.draw()")
        save_motion(page, os.path.join(o.folder, "swimmers.gif" if o.gif else "swimmers.webp"), o.every)


if __name__ == "__main__":
    main()
