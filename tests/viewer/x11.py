"""A client of an X server by libX11 and libXtst alone: real keys and a real mouse, windows, and files that are dropped (XDND)."""
import ctypes
import ctypes.util
import time
import urllib.parse

_x11 = ctypes.CDLL("libX11.so.6")
_xtst = ctypes.CDLL("libXtst.so.6")
_Atom = _Window = _XID = ctypes.c_ulong
_x11.XOpenDisplay.restype = ctypes.c_void_p
_x11.XInternAtom.restype = _Atom
_x11.XDefaultRootWindow.restype = _x11.XCreateSimpleWindow.restype = _Window
_x11.XKeysymToKeycode.restype = ctypes.c_ubyte
_x11.XStringToKeysym.restype = ctypes.c_ulong

_CLIENT_MESSAGE, _SELECTION_REQUEST, _SELECTION_NOTIFY = 33, 30, 31
_ERROR_HANDLER = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
_ignore_error = _ERROR_HANDLER(lambda display, event: 0)  # of windows that are gone meanwhile


class _ClientMessage(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("window", _Window), ("message_type", _Atom), ("format", ctypes.c_int), ("data", ctypes.c_long * 5)]


class _SelectionRequest(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("owner", _Window), ("requestor", _Window), ("selection", _Atom), ("target", _Atom), ("property", _Atom),
                ("time", ctypes.c_ulong)]


class _Selection(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("requestor", _Window), ("selection", _Atom), ("target", _Atom), ("property", _Atom), ("time", ctypes.c_ulong)]


class _Event(ctypes.Union):
    _fields_ = [("type", ctypes.c_int), ("request", _SelectionRequest), ("pad", ctypes.c_long * 24)]


class Client:
    def __init__(self, display):
        _x11.XSetErrorHandler(_ignore_error)
        self.display = ctypes.c_void_p(_x11.XOpenDisplay(display.encode()))
        if not self.display:
            raise RuntimeError(f"no display {display}")
        self.root = _x11.XDefaultRootWindow(self.display)

    def close(self):
        _x11.XCloseDisplay(self.display)

    def atom(self, name):
        return _x11.XInternAtom(self.display, name.encode(), 0)

    def flush(self):
        _x11.XFlush(self.display)

    # --- keys and the mouse, as from hardware

    def hold(self, key, is_down):
        code = _x11.XKeysymToKeycode(self.display, ctypes.c_ulong(_x11.XStringToKeysym(key.encode())))
        _xtst.XTestFakeKeyEvent(self.display, ctypes.c_uint(code), int(is_down), ctypes.c_ulong(0))
        self.flush()

    def press(self, *keys):
        for key in keys:
            self.hold(key, True)
        for key in reversed(keys):
            self.hold(key, False)

    def move(self, x, y):
        _xtst.XTestFakeMotionEvent(self.display, -1, int(x), int(y), ctypes.c_ulong(0))
        self.flush()

    def button(self, number, is_down):
        _xtst.XTestFakeButtonEvent(self.display, ctypes.c_uint(number), int(is_down), ctypes.c_ulong(0))
        self.flush()

    def click(self, x, y, number=1, seconds=0.1):
        """Dear ImGui sees a button that is down in one frame and up in another."""
        self.move(x, y)
        time.sleep(seconds)
        self.button(number, True)
        time.sleep(seconds)
        self.button(number, False)
        time.sleep(seconds)

    # --- windows

    def window(self, word):
        """The newest window whose title has the word; 0: none."""
        root, parent, children, count = _Window(), _Window(), ctypes.POINTER(_Window)(), ctypes.c_uint()
        _x11.XQueryTree(self.display, _Window(self.root), ctypes.byref(root), ctypes.byref(parent), ctypes.byref(children),
                        ctypes.byref(count))
        found = [children[i] for i in range(count.value) if word in self.title(children[i])]
        return found[-1] if found else 0

    def title(self, window):
        name = ctypes.c_char_p()
        _x11.XFetchName(self.display, _Window(window), ctypes.byref(name))
        return (name.value or b"").decode(errors="replace")

    def resize(self, window, width, height):
        _x11.XResizeWindow(self.display, _Window(window), int(width), int(height))
        self.flush()

    def show(self, window, is_shown):
        """Unmapping is what minimising is where no window manager runs."""
        (_x11.XMapWindow if is_shown else _x11.XUnmapWindow)(self.display, _Window(window))
        self.flush()

    def _send(self, window, message, values):
        event = _ClientMessage(_CLIENT_MESSAGE, 0, 1, self.display, window, self.atom(message), 32, (ctypes.c_long * 5)(*values))
        _x11.XSendEvent(self.display, _Window(window), 0, ctypes.c_long(0), ctypes.byref(event))
        self.flush()

    def ask_to_close(self, window):
        """As the button of a window manager does."""
        self._send(window, "WM_PROTOCOLS", [self.atom("WM_DELETE_WINDOW"), 0, 0, 0, 0])

    # --- text and files

    def copied_text(self, seconds=5):
        """What a program has put on the clipboard."""
        window = _x11.XCreateSimpleWindow(self.display, _Window(self.root), 0, 0, 1, 1, 0, ctypes.c_ulong(0), ctypes.c_ulong(0))
        answer = self.atom("SIDERAY_COPIED")
        _x11.XConvertSelection(self.display, _Atom(self.atom("CLIPBOARD")), _Atom(self.atom("UTF8_STRING")), _Atom(answer),
                               _Window(window), ctypes.c_ulong(0))
        self._wait_for(_SELECTION_NOTIFY, seconds)
        kind, form, count, rest = _Atom(), ctypes.c_int(), ctypes.c_ulong(), ctypes.c_ulong()
        text = ctypes.c_char_p()
        _x11.XGetWindowProperty(self.display, _Window(window), _Atom(answer), ctypes.c_long(0), ctypes.c_long(1 << 16), 0, _Atom(0),
                                ctypes.byref(kind), ctypes.byref(form), ctypes.byref(count), ctypes.byref(rest), ctypes.byref(text))
        _x11.XDestroyWindow(self.display, _Window(window))
        self.flush()
        return (text.value or b"").decode()

    def _wait_for(self, kind, seconds):
        """The next event of that kind; None where there is none in time."""
        event, end = _Event(), time.monotonic() + seconds
        while time.monotonic() < end:
            if not _x11.XPending(self.display):
                time.sleep(0.01)
                continue
            _x11.XNextEvent(self.display, ctypes.byref(event))
            if event.type == kind:
                return event
        return None

    def drop(self, window, paths, seconds=5):
        """Drops files on a window as a file manager does; whether the window took them."""
        source = _x11.XCreateSimpleWindow(self.display, _Window(self.root), 0, 0, 1, 1, 0, ctypes.c_ulong(0), ctypes.c_ulong(0))
        selection, kind = self.atom("XdndSelection"), self.atom("text/uri-list")
        _x11.XSetSelectionOwner(self.display, _Atom(selection), _Window(source), ctypes.c_ulong(0))
        self._send(window, "XdndEnter", [source, 5 << 24, kind, 0, 0])
        self._send(window, "XdndPosition", [source, 0, 40 << 16 | 40, 0, self.atom("XdndActionCopy")])
        self._send(window, "XdndDrop", [source, 0, 0, 0, 0])
        text = "".join(f"file://{urllib.parse.quote(str(path))}\r\n" for path in paths).encode()
        taken = self._serve(text, seconds)
        _x11.XDestroyWindow(self.display, _Window(source))
        self.flush()
        return taken

    def _serve(self, text, seconds):
        event = self._wait_for(_SELECTION_REQUEST, seconds)
        if not event:
            return False
        ask = event.request
        _x11.XChangeProperty(self.display, _Window(ask.requestor), _Atom(ask.property), _Atom(ask.target), 8, 0, text, len(text))
        answer = _Selection(_SELECTION_NOTIFY, 0, 1, self.display, ask.requestor, ask.selection, ask.target, ask.property, ask.time)
        _x11.XSendEvent(self.display, _Window(ask.requestor), 0, ctypes.c_long(0), ctypes.byref(answer))
        self.flush()
        return True
