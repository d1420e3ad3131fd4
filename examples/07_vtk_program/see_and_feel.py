"""VTK viewer of a head that can be seen and felt: the mouse is the hand, its wheel presses, a drag rotates the view, q ends. One
function defines opacity and strength. Argument: a CT; default: a synthetic head."""

import sys

import numpy as np
import palpa
import vtk

# The VTK part: an image, a function from values to opacity, a window.
image = palpa.to_vtk(palpa.read_volume(sys.argv[1]) if len(sys.argv) > 1 else palpa.head_phantom(), samples=256)
opacity = vtk.vtkPiecewiseFunction()
for value, share in ((-400, 0.0), (-300, 0.15), (200, 0.15), (400, 0.8), (2000, 1.0)):
    opacity.AddPoint(value, share)
opacity.ClampingOff()
mapper, colors, volume = vtk.vtkGPUVolumeRayCastMapper(), vtk.vtkColorTransferFunction(), vtk.vtkVolume()
mapper.SetInputData(image)
mapper.UseJitteringOn()  # its rays would show rings
colors.AddRGBPoint(0, 0.9, 0.6, 0.5), colors.AddRGBPoint(500, 1.0, 0.98, 0.9)
volume.SetMapper(mapper)
looks = volume.GetProperty()
looks.SetScalarOpacity(opacity), looks.SetColor(colors), looks.SetScalarOpacityUnitDistance(0.01)
looks.ShadeOn(), looks.SetInterpolationTypeToLinear()
renderer, window, interactor = vtk.vtkRenderer(), vtk.vtkRenderWindow(), vtk.vtkRenderWindowInteractor()
renderer.AddVolume(volume), renderer.SetBackground(0.98, 0.98, 0.97)
window.SetSize(800, 600), window.AddRenderer(renderer), interactor.SetRenderWindow(window)
interactor.SetInteractorStyle(vtk.vtkInteractorStyleTrackballCamera())
camera = renderer.GetActiveCamera()
camera.SetPosition(0, -1, 0), camera.SetViewUp(0, 0, 1), renderer.ResetCamera(), camera.Zoom(1.4)

# The haptic part, with this image and this function.
scene = palpa.Scene(stiffness_n_per_m=400)
scene.workspace.towards_user, scene.workspace.up = "-y", "+z"  # the camera's view
ct = scene.add("ct", palpa.from_vtk(image))
scene.add("material", palpa.SurfaceAndFriction(field=ct, strength_n=palpa.strength_from_vtk(opacity, ct, factor=4.0)))
hand = palpa.MouseHand()
hand.put((0.0, 0.01, 0.07))  # in front of the forehead
mouse = palpa.MousePointer(interactor, renderer, hand, scene.hand_to_world())
actors = palpa.FeltActors(renderer, 0.08, scene.hand_to_world())
with palpa.live(scene, device=hand) as live:  # on a thread of its own, which never blocks
    interactor.Initialize()
    actors.follow(live, interactor)
    interactor.Start()
    print(f"felt at the end: {np.linalg.norm(live.latest()['force_n']):.2f} N")
