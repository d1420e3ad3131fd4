// A viewer of VTK's in which a volume is seen and felt: the mouse is the hand, its wheel presses, a drag turns the view. One
// function says what is seen and felt: what is as opaque as can be resists with 4 N. With the name of a picture it moves the
// mouse itself, and ends.
#include <palpa/device/pointer.h>
#include <palpa/palpa.h>
#include <palpa/vtk/felt_actors.h>
#include <palpa/vtk/from_vtk.h>
#include <palpa/vtk/to_vtk.h>
#include <vtkCamera.h>
#include <vtkColorTransferFunction.h>
#include <vtkGPUVolumeRayCastMapper.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkPNGWriter.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>
#include <vtkWindowToImageFilter.h>

#include <thread>

struct Window : vtkCommand {
  static constexpr double push_m = 0.002;  // of a notch of the wheel
  void Execute(vtkObject*, unsigned long event, void*) override {
    if (event == TimerEvent && actors->update()) interactor->Render();
    const int *at = interactor->GetEventPosition(), *before = interactor->GetLastEventPosition();
    vtkCamera& camera = *renderer->GetActiveCamera();
    const double *up = camera.GetViewUp(), *in = camera.GetDirectionOfProjection();
    const palpa::Vec3 u{up[0], up[1], up[2]}, i{in[0], in[1], in[2]}, right = cross(i, u);
    const double per_px_m = 2.0 * camera.GetParallelScale() / renderer->GetSize()[1];
    palpa::Vec3 way_m;  // in the data's world
    if (event == MouseMoveEvent && style->GetState() == 0)
      way_m = per_px_m * ((at[0] - before[0]) * right + (at[1] - before[1]) * u);
    if (event == MouseWheelForwardEvent) way_m = push_m * map.scale * i;
    if (event == MouseWheelBackwardEvent) way_m = -push_m * map.scale * i;
    hand.move(map.turned_to_hand(way_m) / map.scale);
  }
  palpa::Pointer hand;
  palpa::Similarity map;
  std::unique_ptr<palpa::FeltActors> actors;
  vtkNew<vtkRenderer> renderer;
  vtkNew<vtkRenderWindowInteractor> interactor;
  vtkNew<vtkInteractorStyleTrackballCamera> style;
};

int main(int argc, char** argv) {
  // What a program of VTK's has already: an image, and a function from its values to opacities.
  const auto image = palpa::to_vtk(*palpa::head_phantom().fields[0].field, "ct", 128);
  vtkNew<vtkPiecewiseFunction> opacity;
  for (const auto& [value, share] : {std::pair{-400, 0.0}, {-300, 0.15}, {200, 0.15}, {400, 0.8}, {2000, 1.0}})
    opacity->AddPoint(value, share);
  opacity->ClampingOff();

  palpa::Scene scene({.stiffness_n_per_m = 400});
  scene.workspace.towards_user = "-y", scene.workspace.up = "+z";
  const palpa::FieldRef ct = scene.add("ct", palpa::from_vtk(image));
  scene.add("material",
            palpa::SurfaceAndFriction{.field = ct, .strength_n = {ct, palpa::transfer_function_from_vtk(*opacity, 4.0)}});

  vtkNew<vtkGPUVolumeRayCastMapper> mapper;
  mapper->UseJitteringOn();  // else the steps of its rays show as rings
  mapper->SetInputData(image);
  vtkNew<vtkColorTransferFunction> colors;
  colors->AddRGBPoint(0, 0.9, 0.6, 0.5), colors->AddRGBPoint(500, 1.0, 0.98, 0.9);
  vtkNew<vtkVolume> volume;
  volume->SetMapper(mapper);
  volume->GetProperty()->SetScalarOpacity(opacity), volume->GetProperty()->SetColor(colors);
  volume->GetProperty()->SetScalarOpacityUnitDistance(0.01), volume->GetProperty()->ShadeOn();
  volume->GetProperty()->SetInterpolationTypeToLinear();

  const auto window = vtkSmartPointer<Window>::Take(new Window);  // the mouse, as a device
  window->map = scene.hand_to_world();
  window->renderer->AddVolume(volume);
  window->renderer->SetBackground(0.98, 0.98, 0.97);
  window->actors = std::make_unique<palpa::FeltActors>(window->renderer, 0.08, window->map);
  vtkNew<vtkRenderWindow> picture;
  picture->SetSize(800, 600);
  picture->AddRenderer(window->renderer);
  window->interactor->SetRenderWindow(picture);
  window->interactor->SetInteractorStyle(window->style);
  const auto [px, py, pz] = window->map.to_world({0, 0, 1});
  vtkCamera& camera = *window->renderer->GetActiveCamera();
  camera.ParallelProjectionOn(), camera.SetPosition(px, py, pz), camera.SetViewUp(0, 0, 1);
  window->renderer->ResetCamera(), camera.Zoom(1.4);
  window->hand.put({0.0, 0.01, 0.07});  // before the forehead

  palpa::LiveScene live(scene, window->hand.limits());
  palpa::LiveLoop loop(live, window->hand, {.guard = {.motors = false}});
  std::atomic<bool> stop{false};
  std::thread haptic([&] { loop.run(stop, window->actors->observer()); });  // waits for nobody, and nobody for it
  for (const auto event : {vtkCommand::TimerEvent, vtkCommand::MouseMoveEvent}) window->interactor->AddObserver(event, window);
  for (const auto event : {vtkCommand::MouseWheelForwardEvent, vtkCommand::MouseWheelBackwardEvent})
    window->style->AddObserver(event, window);  // in place of its zoom
  double most_n = 0.0;
  window->interactor->Initialize();
  window->interactor->CreateRepeatingTimer(16);
  if (argc < 2) {
    window->interactor->Start();
  } else {
    const auto event = [&](unsigned long which, int x) {
      window->interactor->SetEventInformation(x, 300);
      window->interactor->InvokeEvent(which);
      std::this_thread::sleep_for(std::chrono::milliseconds(16));
      most_n = std::max(most_n, norm(loop.look().frame.result.force_n));
    };
    for (int n = 0; n < 20; ++n) event(vtkCommand::MouseWheelForwardEvent, 400);
    for (int n = 0; n < 30; ++n) event(vtkCommand::MouseMoveEvent, 400 + 2 * n);
    event(vtkCommand::TimerEvent, 460);
    vtkNew<vtkWindowToImageFilter> seen;
    seen->SetInput(picture);
    vtkNew<vtkPNGWriter> png;
    png->SetInputConnection(seen->GetOutputPort());
    png->SetFileName(argv[1]);
    png->Write();
  }
  stop = true;
  haptic.join();
  std::printf("up to %.2f N\n", most_n);
  return argc < 2 || most_n > 0.5 ? 0 : 1;
}
