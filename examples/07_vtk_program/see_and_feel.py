"""The same viewer in Python: the mouse is the hand, its wheel presses, a drag turns the view; one function says what is seen and
felt. With the name of a picture it moves the mouse itself, and ends."""

import sys
import time

import numpy as np
import palpa
import vtk

# What a program of VTK's has already: an image, and a function from its values to opacities.
image = palpa.to_vtk(palpa.head_phantom())
opacity = vtk.vtkPiecewiseFunction()
for value, share in ((-400, 0.0), (-300, 0.15), (200, 0.15), (400, 0.8), (2000, 1.0)):
    opacity.AddPoint(value, share)
opacity.ClampingOff()

scene = palpa.Scene(stiffness_n_per_m=400)
scene.workspace.towards_user, scene.workspace.up = "-y", "+z"
ct = scene.add("ct", palpa.from_vtk(image))
scene.add("material", palpa.SurfaceAndFriction(field=ct, strength_n=palpa.strength_from_vtk(opacity, ct, factor=4.0)))
hand_to_world = scene.hand_to_world()
to_hand = np.linalg.inv(hand_to_world[:3, :3])

mapper, colors, volume = vtk.vtkGPUVolumeRayCastMapper(), vtk.vtkColorTransferFunction(), vtk.vtkVolume()
mapper.SetInputData(image)
mapper.UseJitteringOn()  # else the steps of its rays show as rings
colors.AddRGBPoint(0, 0.9, 0.6, 0.5), colors.AddRGBPoint(500, 1.0, 0.98, 0.9)
volume.SetMapper(mapper)
volume.GetProperty().SetScalarOpacity(opacity), volume.GetProperty().SetColor(colors)
volume.GetProperty().SetScalarOpacityUnitDistance(0.01), volume.GetProperty().ShadeOn()
volume.GetProperty().SetInterpolationTypeToLinear()
renderer, window, interactor = vtk.vtkRenderer(), vtk.vtkRenderWindow(), vtk.vtkRenderWindowInteractor()
renderer.AddVolume(volume), renderer.SetBackground(0.98, 0.98, 0.97)
window.SetSize(800, 600), window.AddRenderer(renderer), interactor.SetRenderWindow(window)
style, camera = vtk.vtkInteractorStyleTrackballCamera(), renderer.GetActiveCamera()
interactor.SetInteractorStyle(style)
camera.ParallelProjectionOn(), camera.SetPosition(*(hand_to_world[:3, :3] @ (0, 0, 1) + hand_to_world[:3, 3])), camera.SetViewUp(0, 0, 1)
camera.SetFocalPoint(*hand_to_world[:3, 3]), renderer.ResetCamera(), camera.Zoom(1.4)

actors, hand = palpa.FeltActors(renderer, 0.08, hand_to_world), palpa.Pointer()
hand.put((0.0, 0.01, 0.07))  # before the forehead


def moved(_, event):
    up, into = np.array(camera.GetViewUp()), np.array(camera.GetDirectionOfProjection())
    per_px_m = 2.0 * camera.GetParallelScale() / renderer.GetSize()[1]
    x, y = np.subtract(interactor.GetEventPosition(), interactor.GetLastEventPosition())
    if event == "MouseMoveEvent" and style.GetState() == 0:
        hand.move(to_hand @ (per_px_m * (x * np.cross(into, up) + y * up)))
    elif "Wheel" in event:
        hand.move(to_hand @ (0.0034 * (1 if "Forward" in event else -1) * into))


interactor.AddObserver("MouseMoveEvent", moved)
style.AddObserver("MouseWheelForwardEvent", moved), style.AddObserver("MouseWheelBackwardEvent", moved)  # in place of its zoom
with palpa.live(scene, device=hand) as live:  # on a thread of its own, which waits for nobody
    interactor.AddObserver("TimerEvent", lambda *_: actors.update(live) and window.Render())
    interactor.Initialize()
    interactor.CreateRepeatingTimer(16)
    most_n = 0.0
    if len(sys.argv) < 2:
        interactor.Start()
    for n in range(50 if len(sys.argv) > 1 else 0):
        interactor.SetEventInformation(400 + 2 * max(n - 20, 0), 300)
        interactor.InvokeEvent("MouseWheelForwardEvent" if n < 20 else "MouseMoveEvent")
        time.sleep(0.016)
        most_n = max(most_n, np.linalg.norm(live.look()["force_n"]))
    if len(sys.argv) > 1:
        interactor.InvokeEvent("TimerEvent")
        seen, png = vtk.vtkWindowToImageFilter(), vtk.vtkPNGWriter()
        seen.SetInput(window), png.SetInputConnection(seen.GetOutputPort()), png.SetFileName(sys.argv[1]), png.Write()
print(f"up to {most_n:.2f} N")
sys.exit(0 if len(sys.argv) < 2 or most_n > 0.5 else 1)
