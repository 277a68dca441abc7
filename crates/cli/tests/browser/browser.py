"""A headless Chromium at the other end of a pipe, asked by the DevTools protocol. Nothing to install besides Chromium."""

import base64
import json
import os
import shutil
import subprocess
import tempfile
import time


def find_chromium():
    return next(filter(None, map(shutil.which, ["chromium", "chromium-browser", "google-chrome"])), None)


class Browser:
    """Opens pages one after the other; WebGL is drawn by the processor, or switched off."""

    def __init__(self, webgl=True):
        drawn = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        options = drawn if webgl else ["--disable-gpu", "--disable-3d-apis"]
        self.folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        to_browser, self.out = os.pipe()
        self.answers, from_browser = os.pipe()

        def pipes():
            # Chromium reads 3 and writes 4. The copies come first, since either may be the other's number.
            ends = [os.dup(to_browser), os.dup(from_browser)]
            ends = [os.dup2(end, 100 + i) for i, end in enumerate(ends)]
            for number, end in zip([3, 4], ends):
                os.dup2(end, number)

        command = [find_chromium(), "--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--hide-scrollbars",
                   f"--user-data-dir={self.folder.name}", *options, "about:blank"]
        self.process = subprocess.Popen(command, preexec_fn=pipes, close_fds=False,
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self.read, self.number, self.session, self.events = b"", 0, None, []
        page = next(t for t in self.ask("Target.getTargets")["targetInfos"] if t["type"] == "page")
        self.session = self.ask("Target.attachToTarget", targetId=page["targetId"], flatten=True)["sessionId"]
        for domain in ["Page", "Runtime", "Network", "Log"]:
            self.ask(f"{domain}.enable")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self.folder.cleanup()

    def ask(self, method, **params):
        self.number += 1
        message = {"id": self.number, "method": method, "params": params}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.out, json.dumps(message).encode() + b"\0")
        while True:
            while b"\0" not in self.read:
                part = os.read(self.answers, 1 << 20)
                assert part, "Chromium has ended"
                self.read += part
            text, self.read = self.read.split(b"\0", 1)
            answer = json.loads(text)
            if answer.get("id") == self.number:
                assert "error" not in answer, answer
                return answer["result"]
            self.events.append(answer)

    def open(self, file, size=(800, 600), dark=False, touch=False, mark="", canvas="document.querySelector('canvas')"):
        """Opens a page and waits until its picture is drawn; seconds from the beginning of the navigation until then."""
        self.ask("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=touch)
        scheme = "dark" if dark else "light"
        self.ask("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        self.events.clear()
        # Another mark alone would not load the page again.
        self.ask("Page.navigate", url="about:blank")
        self.ask("Page.navigate", url=f"file://{os.path.abspath(file)}{mark}")
        end = time.monotonic() + 60
        while time.monotonic() < end:
            drawn = self.run(f"Number({canvas}?.dataset.drawn ?? 0)")
            if drawn:
                return drawn / 1000
            assert not self.faults(), self.faults()
            time.sleep(0.05)
        raise AssertionError(f"{file}: nothing is drawn")

    def run(self, expression):
        result = self.ask("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in result, result["exceptionDetails"]
        return result["result"].get("value")

    def processor_seconds(self):
        """What all processes of the browser have taken of the processor."""
        session, self.session = self.session, None
        processes = self.ask("SystemInfo.getProcessInfo")["processInfo"]
        self.session = session
        return sum(process["cpuTime"] for process in processes)

    def faults(self):
        """What the page complained of, and what it asked for besides itself."""
        def is_fault(event):
            kind, params = event.get("method"), event.get("params", {})
            if kind == "Network.requestWillBeSent":
                return not params["request"]["url"].startswith("file://")
            return kind == "Runtime.exceptionThrown" or kind == "Log.entryAdded" and params["entry"]["level"] == "error"

        return [event for event in self.events if is_fault(event)]

    def shoot(self, file):
        data = self.ask("Page.captureScreenshot", format="png")["data"]
        with open(file, "wb") as out:
            out.write(base64.b64decode(data))
