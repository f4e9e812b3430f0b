#!/usr/bin/env python3
"""Uses a report of `rayloom suite` as a person would, in a real headless Chromium: REPORT.html [FOLDER for screenshots].

Needs Debian's chromium and `pip install playwright` (its client alone: no browser is downloaded). Fails with what is wrong.
"""

import pathlib
import sys
import time

from playwright.sync_api import sync_playwright


def check(what, holds):
    print(("ok    " if holds else "WRONG ") + what)
    if not holds:
        raise SystemExit(1)


def main(report, folder):
    folder.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as p:
        browser = p.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        errors, requests = [], []
        page.on("pageerror", lambda e: errors.append(str(e)))
        page.on("request", lambda r: requests.append(r.url))
        start = time.time()
        page.goto(report.resolve().as_uri())
        page.wait_for_selector(".card canvas, .card .none, .card img")
        n = page.evaluate("DATA.cases.length")
        print(f"{n} cases, {report.stat().st_size / 1e6:.1f} MB, first pictures after {time.time() - start:.2f} s")
        page.screenshot(path=folder / "list.png")
        check("cards are made as one scrolls", page.locator(".card").count() <= 200 or n <= 200)
        last = -1
        while last != page.locator(".card").count():
            last = page.locator(".card").count()
            page.evaluate("scrollTo(0, document.body.scrollHeight)")
            page.wait_for_timeout(150)
        check(f"scrolling reaches all {n}", last == n)
        page.evaluate("scrollTo(0, 0)")
        name = page.evaluate("DATA.cases.find(c => c.pairs.length && c.pairs.every(p => p.ours && p.theirs)).name")
        page.keyboard.press("/")
        page.keyboard.type(name)
        check("the search finds a case", 1 <= page.locator(".card").count() < max(n, 2))
        page.keyboard.press("Escape")
        card = page.locator(".card", has_text=name).first
        card.locator("img").first.wait_for()
        other = card.locator("figure.swap").nth(1)
        hidden = other.locator(".other").evaluate("e => getComputedStyle(e).opacity")
        other.hover()
        shown = other.locator(".other").evaluate("e => getComputedStyle(e).opacity")
        check("hovering swaps to the reference", (hidden, shown) == ("0", "1"))
        card.click()
        page.wait_for_selector("#views canvas")
        check("the address names the case", name in page.evaluate("decodeURIComponent(location.hash)"))
        check("four pictures stand side by side", page.locator("#views canvas").count() == 4)
        page.mouse.move(300, 250)
        check("the pixel under the pointer is told", "column" in page.locator("#pixel").inner_text())
        zoom = page.evaluate("view.zoom")
        page.mouse.wheel(0, -600)
        page.wait_for_timeout(100)
        check("the wheel zooms to pixels", page.evaluate("view.zoom") > 3 * zoom)
        page.screenshot(path=folder / "zoomed.png")
        for key, mode in [("2", "swap"), ("3", "slider"), ("4", "difference"), ("5", "heat")]:
            page.keyboard.press(key)
            check(f"key {key} shows {mode}", page.evaluate("view.mode") == mode and page.locator("#views canvas").count() == 1)
            if mode == "swap":
                page.mouse.move(5, 890)
                page.mouse.move(400, 400)
                check("swap shows the reference while one hovers", page.evaluate("document.querySelector('#views canvas').what") == "theirs")
            if mode == "slider":
                page.mouse.move(700, 400)
                check("the slider follows the pointer", 0.5 < page.evaluate("view.split") < 0.9)
                page.keyboard.press("f")
            page.screenshot(path=folder / f"{mode}.png")
        page.keyboard.press("Escape")
        page.wait_for_timeout(100)
        check("Escape closes", not page.locator("#detail").is_visible())
        check("the page asks for nothing but itself", all(u.startswith(("file:", "data:")) for u in requests))
        check(f"no error in scripts {errors}", not errors)
        browser.close()


main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else "/tmp/report"))
