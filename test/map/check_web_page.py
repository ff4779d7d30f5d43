#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Opens the page of a map in a headless Chromium, served and as a file, and holds it against the tiles.

usage: check_web_page.py FOLDER [--screenshot FILE.png] [--view HASH] [--size WIDTHxHEIGHT]

FOLDER is the one with ept.json and index.html. Ends with 77 where there is no Chromium, and with 1 and a
line where something is not as it should be.
"""
import argparse
import base64
import contextlib
import functools
import http.server
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

TIMEOUT = 300  # s; without a graphics card a frame takes long


def check(holds, problem):
    if not holds:
        sys.exit(problem)


class Browser:
    """Chromium, spoken to by its debugging protocol over a pair of pipes."""

    def __init__(self, program, profile, size):
        commands, self.commands = os.pipe()
        self.answers, answers = os.pipe()

        def connect():  # the protocol reads from 3 and writes to 4
            os.dup2(commands, 13)
            os.dup2(answers, 14)
            os.dup2(13, 3)
            os.dup2(14, 4)

        self.process = subprocess.Popen(
            [program, '--headless', '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader',
             '--enable-unsafe-swiftshader', '--disable-dev-shm-usage', '--remote-debugging-pipe',
             f'--user-data-dir={profile}', f'--window-size={size.replace("x", ",")}', 'about:blank'],
            preexec_fn=connect, close_fds=False, start_new_session=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(commands)
        os.close(answers)
        self.number = 0
        self.buffer = b''
        self.requested = []
        self.session = None
        target = self.send('Target.createTarget', url='about:blank')['targetId']
        self.session = self.send('Target.attachToTarget', targetId=target, flatten=True)['sessionId']
        self.send('Page.enable')
        self.send('Network.enable')
        width, height = size.split('x')
        self.send('Emulation.setDeviceMetricsOverride', width=int(width), height=int(height),
                  deviceScaleFactor=1, mobile=False)

    def send(self, method, **parameters):
        self.number += 1
        message = {'id': self.number, 'method': method, 'params': parameters}
        if self.session:
            message['sessionId'] = self.session
        os.write(self.commands, json.dumps(message).encode() + b'\0')
        while True:
            answer = self.receive()
            if answer.get('method') == 'Network.requestWillBeSent':
                self.requested.append(answer['params']['request']['url'])
            if answer.get('id') == self.number:
                check('error' not in answer, f'{method}: {answer.get("error")}')
                return answer['result']

    def receive(self):
        while b'\0' not in self.buffer:
            part = os.read(self.answers, 1 << 20)
            check(part, 'Chromium ended')
            self.buffer += part
        text, self.buffer = self.buffer.split(b'\0', 1)
        return json.loads(text)

    def value(self, expression):
        return self.send('Runtime.evaluate', expression=expression)['result'].get('value')

    def open(self, address):
        """Loads a page and waits until it shows all that it wants to show."""
        self.send('Page.navigate', url='about:blank')
        self.send('Page.navigate', url=address)
        deadline = time.monotonic() + TIMEOUT
        while time.monotonic() < deadline:
            state = self.value('document.documentElement.dataset.state')
            if state == 'ready':
                return json.loads(self.value('JSON.stringify(document.documentElement.dataset)'))
            check(state != 'failed', self.value('document.getElementById("problem").textContent'))
            time.sleep(0.2)
        sys.exit(f'{address}: not ready after {TIMEOUT} s: {state}')

    def screenshot(self, path):
        path.write_bytes(base64.b64decode(self.send('Page.captureScreenshot', format='png')['data']))

    def close(self):
        """Ends Chromium and its helpers, which outlive it for a moment where the machine is busy."""
        self.process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(timeout=30)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()


@contextlib.contextmanager
def profile_folder():
    """A folder for Chromium. What its dying helpers still write must not fail a page that was right."""
    folder = tempfile.mkdtemp()
    try:
        yield folder
    finally:
        deadline = time.monotonic() + 10
        while os.path.exists(folder) and time.monotonic() < deadline:
            shutil.rmtree(folder, ignore_errors=True)
            time.sleep(0.05)


class Silent(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@contextlib.contextmanager
def served(folder):
    """The address of a server of the folder's files, on the loopback."""
    handler = functools.partial(Silent, directory=str(folder))
    with http.server.ThreadingHTTPServer(('127.0.0.1', 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f'http://127.0.0.1:{server.server_address[1]}/'
        server.shutdown()


def check_page(browser, folder, options):
    ept = json.loads((folder / 'ept.json').read_text())
    size = sum(dimension['size'] for dimension in ept['schema'])
    root = (folder / 'ept-data' / '0-0-0-0.bin').stat().st_size // size
    with served(folder) as address:
        shown = browser.open(address + (f'#{options.view}' if options.view else ''))
        check(int(shown['points']) >= root, f'{shown["points"]} points are shown, the root has {root}')
        check(int(shown['points']) <= ept['points'], 'more points are shown than there are')
        if options.screenshot:
            browser.screenshot(options.screenshot)
        check(len(browser.requested) > 5, f'requests: {browser.requested}')
        for url in browser.requested:
            check(url.startswith((address, 'about:', 'data:')), f'the page asked for {url}')
        return shown


def check_view_is_kept(browser, address):
    """A link with a view opens that view."""
    view = 'at=%s&d=33.0&az=90.0&el=20.0&c=time&show=loops'
    place = browser.value('lidarMap.page.origin.map(v => v.toFixed(2)).join()')
    wanted = '#' + view % place
    browser.open(address + wanted)
    browser.value('lidarMap.page.writeHash()')
    check(browser.value('location.hash') == wanted, f'{browser.value("location.hash")} in place of {wanted}')
    check(browser.value('lidarMap.page.points.colour') == 'time', 'the colour of the link')


def check_picking(browser, folder):
    """The ray through the middle of the window meets a point of the map near the target of the view."""
    ept = json.loads((folder / 'ept.json').read_text())
    browser.value('lidarMap.page.home(true); lidarMap.page.draw()')
    place = browser.value(
        '(() => { const page = lidarMap.page, node = page.points.visible[0];'
        ' const p = node.mesh.geometry.attributes.position.array;'
        ' const at = new THREE.Vector3(p[0], p[1], p[2]);'
        ' page.camera.goTo(at, 20); page.draw(); const c = page.canvas;'
        ' const found = page.pick(c.clientWidth / 2, c.clientHeight / 2);'
        ' return JSON.stringify([found.distanceTo(at), ...found.toArray().map((v, i) => v + page.origin[i])]); })()')
    distance, *place = json.loads(place)
    check(distance < 3.0, f'the point that was aimed at is {distance} m away')
    low, high = ept['boundsConforming'][:3], ept['boundsConforming'][3:]
    check(all(a - 0.01 <= v <= b + 0.01 for a, v, b in zip(low, place, high)), f'{place} is outside of the map')


def check_changes(browser):
    """Each change is in the list and has its box, colour and dates; a click shows the layer and leads there."""
    count = browser.value('lidarMap.marks.changes.length')
    if count == 0:
        return
    buttons = json.loads(browser.value(
        'JSON.stringify([...document.querySelectorAll("#changes button")].map(b => [b.className, b.textContent]))'))
    check(len(buttons) == min(count, 200), f'{len(buttons)} of {count} changes are in the list')
    for kind, text in buttons:
        verb = {'appeared': 'came', 'disappeared': 'went'}[kind]
        check(re.fullmatch(verb + r' \d{4}-\d\d-\d\d \d\d:\d\d to \d{4}-\d\d-\d\d \d\d:\d\d, [0-9. ×]+ m', text),
              f'the list has "{text}" for what has {kind}')
    corners = browser.value('lidarMap.page.overlay.groups.changes.children.reduce('
                            '(sum, mesh) => sum + mesh.geometry.attributes.position.count, 0)')
    check(corners == 12 * 4 * count, f'{corners} corners of lines for {count} boxes')
    box = 'document.querySelector("[data-mark=changes]")'
    check(browser.value(f'{box}.checked') is False, 'changes are shown before they are wanted')
    browser.value('document.querySelector("#changes button").click(); lidarMap.page.draw()')
    check(browser.value(f'{box}.checked') is True, 'a click in the list does not show the changes')
    found = json.loads(browser.value(
        '(() => { const page = lidarMap.page, at = page.camera.target.toArray().map((v, i) => v + page.origin[i]);'
        ' return JSON.stringify([page.textAt(at), document.querySelector("#changes button").textContent]); })()'))
    # Where boxes overlap, the smaller one is named.
    check(any(found[0].endswith(text) for _, text in buttons), f'"{found[0]}" is said of the place of "{found[1]}"')
    browser.value(f'{box}.click(); lidarMap.page.draw()')
    check(browser.value('lidarMap.page.overlay.groups.changes.visible') is False, 'changes cannot be switched off')


def check_degrees(browser, folder):
    """The corner of the map in degrees, as GDAL has it."""
    ept = json.loads((folder / 'ept.json').read_text())
    if not ept['srs']:
        return
    try:
        from osgeo import osr
    except ImportError:
        print('python3-gdal is not installed: degrees are not compared')
        return
    system, degrees = osr.SpatialReference(), osr.SpatialReference()
    system.ImportFromWkt(ept['srs']['wkt'])
    degrees.ImportFromEPSG(4326)
    x, y = ept['boundsConforming'][:2]
    wanted = osr.CoordinateTransformation(system, degrees).TransformPoint(x, y)
    found = json.loads(browser.value(f'JSON.stringify(lidarMap.degrees({ept["srs"]["horizontal"]}, {x}, {y}))'))
    check(all(abs(a - b) < 1e-9 for a, b in zip(found, wanted)), f'{found} in place of {wanted}')


def check_as_file(browser, folder):
    """Opened as a file the page shows at least the root, and says how to see the rest."""
    shown = browser.open((folder / 'index.html').as_uri())
    ept = json.loads((folder / 'ept.json').read_text())
    size = sum(dimension['size'] for dimension in ept['schema'])
    root = (folder / 'ept-data' / '0-0-0-0.bin').stat().st_size // size
    check(int(shown['points']) >= root, 'as a file: fewer points than the root has')


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('folder', type=pathlib.Path)
    parser.add_argument('--screenshot', type=pathlib.Path)
    parser.add_argument('--view', help='the part of the address behind #')
    parser.add_argument('--size', default='640x400', help='of the window')
    options = parser.parse_args()
    program = shutil.which('chromium') or shutil.which('chromium-browser')
    if program is None:
        print('chromium is not installed: the page was not opened')
        sys.exit(77)
    folder = options.folder.resolve()
    with profile_folder() as profile:
        browser = Browser(program, profile, options.size)
        try:
            shown = check_page(browser, folder, options)
            print(f'{shown["points"]} points, first picture after {shown["firstPicture"]} ms')
            if options.screenshot:
                return
            check_degrees(browser, folder)
            check_picking(browser, folder)
            check_changes(browser)
            with served(folder) as address:
                check_view_is_kept(browser, address)
            check_as_file(browser, folder)
        finally:
            browser.close()


if __name__ == '__main__':
    main()
