"""The picture of docs/paraview.md: a slice of the wing's data, the path of the proxy as a tube, and arrows of force.

Usage: pvpython --force-offscreen-rendering tools/figures/in_paraview.py DATA.vti WAY.vtp PICTURE.png
"""

import sys

from paraview.simple import (ColorBy, CreateView, GetColorTransferFunction, GetScalarBar, Glyph, SaveScreenshot, Show, Slice, Tube,
                             UpdatePipeline, XMLImageDataReader, XMLPolyDataReader)

data_file, way_file, picture = sys.argv[1:4]
size = [1000, 600]
ink = [0.1, 0.1, 0.1]

view = CreateView("RenderView")
view.ViewSize = size
view.UseColorPaletteForBackground = 0
view.Background = [1, 1, 1]
view.OrientationAxesLabelColor = ink


def explained(shown, array, title, top, label):
    """Shows the colours of an array in a bar at the right."""
    colors = GetColorTransferFunction(array)
    bar = GetScalarBar(colors, view)
    bar.Title, bar.ComponentTitle, bar.HorizontalTitle = title, "", 1
    bar.TitleColor = bar.LabelColor = ink
    bar.TitleFontSize, bar.LabelFontSize = 17, 15
    bar.AutomaticLabelFormat, bar.LabelFormat, bar.RangeLabelFormat = 0, label, label
    bar.WindowLocation, bar.Position, bar.ScalarBarLength = "Any Location", [0.88, top], 0.32
    shown.SetScalarBarVisibility(view, True)
    return colors


data = XMLImageDataReader(FileName=[data_file])
way = XMLPolyDataReader(FileName=[way_file])
UpdatePipeline()
low_x, high_x, low_y, high_y, low_z, high_z = way.GetDataInformation().GetBounds()
middle = [(low_x + high_x) / 2, (low_y + high_y) / 2, (low_z + high_z) / 2]
length = max(high_x - low_x, high_y - low_y, high_z - low_z)

across = Slice(Input=data)
across.SliceType.Origin = [low_x - 0.02 * length, middle[1], middle[2]]
across.SliceType.Normal = [1, 0, 0]
shown = Show(across, view)
shown.Ambient, shown.Diffuse = 0.75, 0.25
ColorBy(shown, ("POINTS", "velocity", "Magnitude"))
speeds = explained(shown, "velocity", "velocity / (m/s)", 0.08, "%.2f")
speeds.ColorSpace = "RGB"
speeds.RGBPoints = [0.80, 0.35, 0.55, 0.75, 0.95, 0.72, 0.83, 0.92, 1.05, 0.97, 0.97, 0.97]

tube = Tube(Input=way)
tube.Radius = 0.0045 * length
shown = Show(tube, view)
ColorBy(shown, ("POINTS", "force_n", "Magnitude"))
forces = explained(shown, "force_n", "force_n / N", 0.55, "%.1f")
forces.ApplyPreset("Inferno (matplotlib)", True)
forces.InvertTransferFunction()
forces.RescaleTransferFunction(0, 2.5)

arrows = Glyph(Input=way, GlyphType="Arrow")
arrows.OrientationArray = arrows.ScaleArray = ["POINTS", "force_n"]
arrows.ScaleFactor = 0.07 * length
arrows.GlyphMode, arrows.Stride = "Every Nth Point", 150
shown = Show(arrows, view)
shown.ColorArrayName = [None, ""]
shown.AmbientColor = shown.DiffuseColor = [0.15, 0.15, 0.15]

view.CameraParallelProjection = 1
view.CameraFocalPoint = middle
view.CameraPosition = [middle[0] + 3 * length, middle[1] - 1.2 * length, middle[2] + 1.2 * length]
view.CameraViewUp = [0, 0, 1]
view.CameraParallelScale = 0.5 * length
SaveScreenshot(picture, view, ImageResolution=size)
