// A viewer of VTK's in which a head is seen and felt: the mouse is the hand, its wheel presses, a drag turns the view, q ends.
// One function says what is seen and felt: what is as opaque as can be resists with 4 N. Name a CT, or see a drawn head.
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
  // What a program of VTK's has already: an image, a function from its values to opacities, a window.
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
  mapper->SetInputData(image), mapper->UseJitteringOn(), volume->SetMapper(mapper);  // without jitter its rays show rings
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
  // What is felt: the same image, by the same function.
  palpa::Scene scene({.stiffness_n_per_m = 400});
  scene.workspace.towards_user = "-y", scene.workspace.up = "+z";  // as the camera looks at it
  const palpa::FieldRef ct = scene.add("ct", palpa::from_vtk(image));
  scene.add("material",
            palpa::SurfaceAndFriction{.field = ct, .strength_n = {ct, palpa::transfer_function_from_vtk(*opacity, 4.0)}});
  palpa::MouseHand hand;
  hand.put({0.0, 0.01, 0.07});  // before the forehead
  palpa::MousePointer mouse(interactor, renderer, hand, scene.hand_to_world());
  palpa::FeltActors actors(renderer, 0.08, scene.hand_to_world());
  palpa::LiveScene live(scene, hand.limits());
  palpa::LiveLoop loop(live, hand, {.guard = {.motors = false}});
  std::atomic<bool> stop{false};
  std::thread haptic([&] { loop.run(stop, actors.observer()); });  // waits for nobody, and nobody for it
  actors.follow(interactor);
  interactor->Start();
  stop = true, haptic.join();
  std::printf("felt at the end: %.2f N\n", norm(loop.latest().frame.result.force_n));
} catch (const palpa::LoadError& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 2;
}
