// A VTK viewer of a head that can be seen and felt: the mouse is the hand, its wheel presses, a drag rotates the view, q ends.
// One function defines opacity and strength: full opacity resists with 4 N. Argument: a CT; default: a synthetic head.
#include <palpa/palpa.h>
#include <palpa/vtk.h>
#include <vtkColorTransferFunction.h>
#include <vtkGPUVolumeRayCastMapper.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkRenderWindow.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include <thread>

int main(int argc, char** argv) try {
  // The VTK part: an image, a function from values to opacity, a window.
  const palpa::Volume head = argc > 1 ? palpa::read_volume(argv[1]) : palpa::head_phantom();
  const auto image = palpa::to_vtk(*head.fields[0].field, "ct", 256);
  vtkNew<vtkPiecewiseFunction> opacity;
  for (const auto& [value, share] : {std::pair{-400, 0.0}, {-300, 0.15}, {200, 0.15}, {400, 0.8}, {2000, 1.0}})
    opacity->AddPoint(value, share);
  opacity->ClampingOff();
  vtkNew<vtkColorTransferFunction> colors;
  colors->AddRGBPoint(0, 0.9, 0.6, 0.5), colors->AddRGBPoint(500, 1.0, 0.98, 0.9);
  vtkNew<vtkGPUVolumeRayCastMapper> mapper;
  vtkNew<vtkVolume> volume;
  mapper->SetInputData(image), mapper->UseJitteringOn(), volume->SetMapper(mapper);  // its rays would show rings
  vtkVolumeProperty& looks = *volume->GetProperty();
  looks.SetScalarOpacity(opacity), looks.SetColor(colors), looks.SetScalarOpacityUnitDistance(0.01);
  looks.ShadeOn(), looks.SetInterpolationTypeToLinear();
  vtkNew<vtkRenderer> renderer;
  renderer->AddVolume(volume), renderer->SetBackground(0.98, 0.98, 0.97);
  vtkNew<vtkRenderWindow> window;
  window->SetSize(800, 600), window->AddRenderer(renderer);
  vtkNew<vtkRenderWindowInteractor> interactor;
  interactor->SetRenderWindow(window), interactor->SetInteractorStyle(vtkNew<vtkInteractorStyleTrackballCamera>());
  vtkCamera& camera = *renderer->GetActiveCamera();
  camera.SetPosition(0, -1, 0), camera.SetViewUp(0, 0, 1), renderer->ResetCamera(), camera.Zoom(1.4);
  interactor->Initialize();
  // The haptic part, with this image and this function.
  palpa::Scene scene({.stiffness_n_per_m = 400});
  scene.edit<palpa::Workspace>([&](auto& workspace) {
    workspace.towards_user = "-y";
    workspace.up = "+z";
  });  // the camera's view
  const palpa::FieldRef ct = scene.add("ct", palpa::from_vtk(image));
  scene.add("material",
            palpa::SurfaceAndFriction{.field = ct, .strength_n = {ct, palpa::transfer_function_from_vtk(*opacity, 4.0)}});
  palpa::MouseHand hand;
  hand.put({0.0, 0.01, 0.07});  // in front of the forehead
  palpa::MousePointer mouse(interactor, renderer, hand, scene.hand_to_world());
  palpa::FeltActors actors(renderer, 0.08, scene.hand_to_world());
  palpa::LiveScene live(scene, hand.limits());
  palpa::LiveLoop loop(live, hand, {.guard = {.motors = false}});
  std::atomic<bool> stop{false};
  std::thread haptic([&] { loop.run(stop, actors.observer()); });  // never blocks the window's thread, nor is blocked by it
  actors.follow(interactor);
  interactor->Start();
  stop = true, haptic.join();
  std::printf("felt at the end: %.2f N\n", norm(loop.latest().frame.result.force_n));
} catch (const palpa::LoadError& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 2;
}
