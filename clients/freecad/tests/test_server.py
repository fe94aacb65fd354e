"""Servers that are missing, stop, or reject requests."""

from PySide import QtGui

from freecad.piad_workbench import server
from helpers import PROGRAM, Server, WorkbenchTest, dome, panel, preferences, until, wave


class Servers(WorkbenchTest):
    def failure(self, it):
        return until(lambda: it._preview.error, what=it.status.text()) and until(it.again.isVisible) and it.status.text()

    def test_own_program_listens_on_the_loopback_only(self):
        it = self.open("Piad_FitCurve", self.polygon(wave()))
        until(lambda: it._ended)
        self.assertRegex(server._OWN._address, r"^http://127\.0\.0\.1:\d+$")
        self.assertNotEqual(server._OWN._address, "http://127.0.0.1:8080")

    def test_address_in_the_preferences(self):
        self.server = Server()
        preferences(Server=self.server.address)
        it = self.open("Piad_FitCurve", self.polygon(wave()))
        until(lambda: it._ended)
        with self.server.client() as client:
            self.assertEqual([job.id for job in client.jobs()], [it._preview.job.id])

    def test_server_that_goes_away_in_the_middle(self):
        self.server = Server()
        preferences(Server=self.server.address)
        cloud = self.cloud(dome(20000, 0.05))
        it = self.open("Piad_FitSurface", cloud)
        it.settings.widgets["tolerance"].setProperty("rawValue", 0.03)
        until(lambda: it._last and it._preview.settings.tolerance == 0.03 and it._preview.running)
        self.server.kill()
        text = self.failure(it)
        self.picture("lost")
        self.assertIn(self.server.address.split("//")[1], text)
        self.assertRegex(text, "cannot reach|lost the connection")
        self.assertFalse(it.accept())
        self.assertEqual(self.document.Objects, [cloud])
        preferences(Program=PROGRAM)
        it.settings.widgets["tolerance"].setProperty("rawValue", 0.5)
        until(lambda: it._ended, what=it.status.text())
        self.assertFalse(it.again.isVisible())

    def test_own_program_that_goes_away_is_started_again(self):
        it = self.open("Piad_FitCurve", self.polygon(wave()))
        until(lambda: it._ended)
        server._OWN._process.kill()
        server._OWN._process.wait()
        it.settings.widgets["tolerance"].setProperty("rawValue", 0.5)
        until(lambda: it._ended and it._preview.settings.tolerance == 0.5, what=it.status.text())

    def test_address_that_is_none(self):
        preferences(Server="localhost:8080")
        it = self.open("Piad_FitCurve", self.polygon(wave()))
        self.assertIn("http://localhost:8080", self.failure(it))
        self.picture("address")

    def test_nobody_listens(self):
        preferences(Server="http://127.0.0.1:9")
        it = self.open("Piad_FitCurve", self.polygon(wave()))
        self.assertIn("cannot reach http://127.0.0.1:9", self.failure(it))

    def test_no_program(self):
        server._OWN.stop()
        preferences(Program="/nowhere/piad")
        it = self.open("Piad_FitCurve", self.polygon(wave()))
        self.assertIn("/nowhere/piad", self.failure(it))
        preferences(Program=PROGRAM)
        it.again.click()
        until(lambda: it._ended, what=it.status.text())

    def test_program_that_does_not_start(self):
        server._OWN.stop()
        preferences(Program="/bin/false")
        it = self.open("Piad_FitCurve", self.polygon(wave()))
        self.assertIn("/bin/false did not start", self.failure(it))

    def test_equal_points(self):
        wire = self.polygon(wave(10))
        names = ["Vertex1", "Vertex2", "Vertex3"]
        twin = self.polygon(wave(10))
        it = self.open("Piad_FitCurve", *[(wire, name) for name in names], (twin, "Vertex3"))
        text = self.failure(it)
        self.picture("refused")
        self.assertIn("/curve/points/3", text)
        self.assertIn("equals", text)
        self.assertEqual(QtGui.QApplication.activeModalWidget(), None)

    def test_points_that_are_no_numbers(self):
        points = dome(100)
        points[17] = (0.0, float("nan"), 1.0)
        it = self.open("Piad_FitSurface", self.cloud(points))
        text = self.failure(it)
        self.assertRegex(text, r"surface\.scattered\[17\]\[\d\] is nan")

    def test_nothing_to_fit(self):
        group = self.document.addObject("App::DocumentObjectGroup", "Group")
        before = panel()
        self.open("Piad_FitSurface", group)
        self.assertIs(panel(), before)
        box = until(lambda: [it for it in QtGui.QApplication.topLevelWidgets() if isinstance(it, QtGui.QMessageBox)])[0]
        self.assertIn("Group", box.text())
        box.close()

    def test_program_ends_with_freecad(self):
        it = self.open("Piad_FitCurve", self.polygon(wave()))
        until(lambda: it._ended)
        process = server._OWN._process
        server._OWN.stop()
        self.assertIsNotNone(process.poll())
