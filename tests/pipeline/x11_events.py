"""Does what xdotool cannot do: files dragged onto a window (the XDND protocol, version 5), a window beside ours."""
import time
import urllib.parse

from Xlib import X, display
from Xlib.protocol import event


class DragSource:
    """A client that drops files onto `window`, as a file manager does."""

    def __init__(self, window):
        self.display = display.Display()
        self.atom = self.display.intern_atom
        self.target = self.display.create_resource_object("window", int(window))
        self.source = self.display.screen().root.create_window(0, 0, 1, 1, 0, X.CopyFromParent)

    def send(self, name, *data):
        message = event.ClientMessage(window=self.target, client_type=self.atom(name),
                                      data=(32, [self.source.id, *data] + [0] * (4 - len(data))))
        self.target.send_event(message)
        self.display.flush()

    def wait(self, found):
        end = time.time() + 20
        while time.time() < end:
            if not self.display.pending_events():
                time.sleep(0.01)
                continue
            it = self.display.next_event()
            if it.type == X.SelectionRequest:
                self.hand_over(it)
            if found(it):
                return
        raise AssertionError("the window does not answer the drag")

    def hand_over(self, request):
        request.requestor.change_property(request.property, request.target, 8, self.text)
        self.display.send_event(request.requestor, event.SelectionNotify(
            time=request.time, requestor=request.requestor, selection=request.selection, target=request.target,
            property=request.property))
        self.display.flush()

    def answer(self, name):
        self.wait(lambda it: it.type == X.ClientMessage and it.client_type == self.atom(name))

    def drop(self, paths, at=(400, 200)):
        self.text = "".join("file://" + urllib.parse.quote(path) + "\r\n" for path in paths).encode()
        self.source.set_selection_owner(self.atom("XdndSelection"), X.CurrentTime)
        self.send("XdndEnter", 5 << 24, self.atom("text/uri-list"))
        corner = self.target.translate_coords(self.display.screen().root, 0, 0)
        x, y = at[0] - corner.x, at[1] - corner.y
        self.send("XdndPosition", 0, x << 16 | y, X.CurrentTime, self.atom("XdndActionCopy"))
        self.answer("XdndStatus")
        self.send("XdndDrop", 0, X.CurrentTime)
        self.answer("XdndFinished")
        self.display.close()


def another_window():
    """Makes a mapped window of somebody else. Close its display() to be rid of it."""
    connection = display.Display()
    window = connection.screen().root.create_window(900, 700, 200, 100, 0, X.CopyFromParent)
    window.set_wm_name("other")
    window.map()
    connection.sync()
    return connection, window.id
