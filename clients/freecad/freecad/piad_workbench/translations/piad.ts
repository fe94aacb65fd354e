<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1">
<context>
    <name>App::Property</name>
    <message>
        <location filename="../feature.py" line="24"/>
        <source>Where the points come from. Without it they are those that are kept here.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../feature.py" line="24"/>
        <source>The points, in the order of the source.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../feature.py" line="24"/>
        <source>The number of rows of a grid of points.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../feature.py" line="24"/>
        <source>Points of a curve, a grid or a cloud.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../feature.py" line="24"/>
        <source>The points that were dragged.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../feature.py" line="24"/>
        <source>Where these are.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../feature.py" line="24"/>
        <source>How far each point is from the shape.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../feature.py" line="24"/>
        <source>The points and settings of the shape, as a digest.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../feature.py" line="24"/>
        <source>The version of piad that has fitted the shape.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../feature.py" line="24"/>
        <source>How many control points the shape has.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../feature.py" line="24"/>
        <source>How far the shape is from the points.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../feature.py" line="24"/>
        <source>How the fit has ended.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../view.py" line="19"/>
        <source>Shows the points in the colours of their distances.</source>
        <translation type="unfinished"></translation>
    </message>
</context>
<context>
    <name>Form</name>
    <message>
        <location filename="../resources/preferences.ui" line="5"/>
        <source>Server</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../resources/preferences.ui" line="7"/>
        <source>Address</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../resources/preferences.ui" line="10"/>
        <source>https://fits.example.org</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../resources/preferences.ui" line="11"/>
        <source>The server that fits. Empty: the program below is started, on a free port of this computer.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../resources/preferences.ui" line="16"/>
        <source>Token</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../resources/preferences.ui" line="19"/>
        <source>For a server that asks for one. It is kept in the settings of FreeCAD, readable.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../resources/preferences.ui" line="25"/>
        <source>Program</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../resources/preferences.ui" line="28"/>
        <source>The program piad, which is started where there is no address. Empty: the one in the search path.</source>
        <translation type="unfinished"></translation>
    </message>
</context>
<context>
    <name>piad</name>
    <message>
        <location filename="../drag.py" line="47"/>
        <source>Drag points</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../commands.py" line="55"/>
        <source>Drag points of a fitted curve or surface: select it first</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../panel.py" line="62"/>
        <source>Fit a curve</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../commands.py" line="83"/>
        <source>Fit a curve through selected points, a wire, a sketch or a list of points</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../panel.py" line="62"/>
        <source>Fit a surface</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../commands.py" line="89"/>
        <source>Fit a surface to selected point clouds or meshes</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../drag.py" line="49"/>
        <source>Drag a point with the left mouse button: it moves in the plane of the screen, and the shape follows.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../drag.py" line="51"/>
        <source>Preparing: the server fits the points as they are…</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../drag.py" line="54"/>
        <source>Undo the last move</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../drag.py" line="112"/>
        <source>Drag a point.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../drag.py" line="122"/>
        <source>within the tolerance</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../drag.py" line="122"/>
        <source>outside of the tolerance</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../drag.py" line="124"/>
        <source>{} control points, largest distance {:.3g} mm: {}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../form.py" line="31"/>
        <source>Back to the defaults</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../init_gui.py" line="15"/>
        <source>Fit curves and surfaces to points</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../panel.py" line="64"/>
        <source>{} points</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../panel.py" line="72"/>
        <source>Try again</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../panel.py" line="75"/>
        <source>Show distances as colours</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../panel.py" line="229"/>
        <source>Fitting…</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../panel.py" line="159"/>
        <source>The fit has not ended: wait for it, or choose a larger tolerance.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../panel.py" line="198"/>
        <source>tolerance</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../panel.py" line="200"/>
        <source>outside</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../panel.py" line="223"/>
        <source>A rough surface to lay the points on…</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../panel.py" line="226"/>
        <source>{} control points, iteration {}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../panel.py" line="227"/>
        <source>Largest distance {}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../points.py" line="102"/>
        <source>Select two points or more, a wire, a sketch or a list of points.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../points.py" line="111"/>
        <source>Select a point cloud or a mesh with four points or more.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../points.py" line="140"/>
        <source>{} has no points.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../points.py" line="155"/>
        <source>The selected edges are not one wire.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../server.py" line="44"/>
        <source>The workbench needs the Python package {}: install it for FreeCAD&apos;s Python.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../server.py" line="54"/>
        <source>The server in the preferences: {}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../server.py" line="90"/>
        <source>There is no program {!r}: install piad, or set its path or the address of a server in the preferences (piad).</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../server.py" line="103"/>
        <source>{} did not start: {}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../server.py" line="104"/>
        <source>it is not listening</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="14"/>
        <source>Off</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="15"/>
        <source>Light</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="16"/>
        <source>Medium</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="17"/>
        <source>Strong</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="35"/>
        <source>Tolerance</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="35"/>
        <source>How far the shape may be from the points. A larger one needs fewer control points.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="35"/>
        <source>Degree</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="35"/>
        <source>3 suits most shapes. 5 lets curvature change more evenly, 1 makes straight pieces.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="35"/>
        <source>Smoothing</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="35"/>
        <source>Evens out noise and bridges gaps. Too much of it keeps the shape away from the points.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="35"/>
        <source>Most control points</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="35"/>
        <source>A limit, in each direction of a surface. 0 is none: as many as the tolerance needs.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="35"/>
        <source>Closed</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="35"/>
        <source>Continues smoothly from the last point to the first.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="35"/>
        <source>Exactly through the ends</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="35"/>
        <source>Switch it off if the first and the last point are as noisy as the others.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="35"/>
        <source>Steep or bent shape</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../settings.py" line="35"/>
        <source>Lays the points on a rough surface first rather than on a plane. Switch it off for flat shapes, to save time.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../panel.py" line="231"/>
        <source>Within the tolerance.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <location filename="../panel.py" line="234"/>
        <source>Outside of the tolerance.</source>
        <translation type="unfinished"></translation>
    </message>
</context>
</TS>
