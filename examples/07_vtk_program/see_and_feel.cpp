// A viewer of VTK's in which a volume is seen and felt: the mouse is the hand, its wheel presses, a drag turns the view, q ends.
// One function says what is seen and felt: what is as opaque as can be resists with 4 N.
#include <palpa/palpa.h>
#include <palpa/vtk/felt_actors.h>
#include <palpa/vtk/from_vtk.h>
#include <palpa/vtk/mouse_pointer.h>
#include <palpa/vtk/to_vtk.h>
#include <vtkColorTransferFunction.h>
#include <vtkGPUVolumeRayCastMapper.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkRenderWindow.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include <thread>

int main() {
  // What a program of VTK's has already: an image, a function from its values to opacities, a window.
  const auto image = palpa::to_vtk(*palpa::head_phantom().fields[0].field, "ct", 128);
  vtkNew<vtkPiecewiseFunction> opacity;
  for (const auto& [value, share] : {std::pair{-400, 0.0}, {-300, 0.15}, {200, 0.15}, {400, 0.8}, {2000, 1.0}})
    opacity->AddPoint(value, share);
  opacity->ClampingOff();
  vtkNew<vtkColorTransferFunction> colors;
  colors->AddRGBPoint(0, 0.9, 0.6, 0.5), colors->AddRGBPoint(500, 1.0, 0.98, 0.9);
  vtkNew<vtkGPUVolumeRayCastMapper> mapper;
  mapper->SetInputData(image), mapper->UseJitteringOn();  // else the steps of its rays show as rings
  vtkNew<vtkVolume> volume;
  volume->SetMapper(mapper);
  vtkVolumeProperty& looks = *volume->GetProperty();
  looks.SetScalarOpacity(opacity), looks.SetColor(colors), looks.SetScalarOpacityUnitDistance(0.01);
  looks.ShadeOn(), looks.SetInterpolationTypeToLinear();
  vtkNew<vtkRenderer> renderer;
  renderer->AddVolume(volume), renderer->SetBackground(0.98, 0.98, 0.97);
  vtkNew<vtkRenderWindow> window;
  window->SetSize(800, 600), window->AddRenderer(renderer);
  vtkNew<vtkRenderWindowInteractor> interactor;
  vtkNew<vtkInteractorStyleTrackballCamera> style;
  interactor->SetRenderWindow(window), interactor->SetInteractorStyle(style);
  vtkCamera& camera = *renderer->GetActiveCamera();
  camera.SetPosition(0, -1, 0), camera.SetViewUp(0, 0, 1), renderer->ResetCamera(), camera.Zoom(1.4);

  // What is felt: the same image, by the same function.
  palpa::Scene scene({.stiffness_n_per_m = 400});
  scene.workspace.towards_user = "-y", scene.workspace.up = "+z";  // as the camera looks at it
  const palpa::FieldRef ct = scene.add("ct", palpa::from_vtk(image));
  scene.add("material",
            palpa::SurfaceAndFriction{.field = ct, .strength_n = {ct, palpa::transfer_function_from_vtk(*opacity, 4.0)}});
  palpa::Pointer hand;
  hand.put({0.0, 0.01, 0.07});  // before the forehead
  palpa::MousePointer mouse(interactor, renderer, hand, scene.hand_to_world());
  palpa::FeltActors actors(renderer, 0.08, scene.hand_to_world());
  palpa::LiveScene live(scene, hand.limits());
  palpa::LiveLoop loop(live, hand, {.guard = {.motors = false}});
  std::atomic<bool> stop{false};
  double most_n = 0.0;
  std::thread haptic([&] {  // waits for nobody, and nobody for it
    loop.run(stop, [&](const palpa::TickFrame& frame, const palpa::Session& session) {
      actors.give(frame, session);
      most_n = std::max(most_n, norm(frame.result.force_n));
    });
  });
  interactor->Initialize();
  actors.follow(interactor);
  interactor->Start();
  stop = true;
  haptic.join();
  std::printf("up to %.2f N\n", most_n);
}
