// The core lines that vortex_line feels behind a wing, beside those of VTK's vortex-core filter (parallel vectors).
//
//   bench_vortex_core DATA_FOLDER     reads cfd_wing/wing.vti there
//
// Ours: from every voxel of the fluid where Q is at least 5 % of its maximum, the steps of vortex_line are followed until
// they rest. VTK's: the lines of vtkVortexCore from the velocity of the file, and from the velocity smoothed as ours is,
// where Q is as large. Both are judged by a third, the minimum of the (smoothed) pressure across the axis.
#include <palpa/palpa.h>
#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkIdList.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkVortexCore.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "palpa/data/derived.h"
#include "palpa/data/grid.h"
#include "palpa/data/quantile.h"

namespace {

using namespace palpa;

constexpr double threshold_share = 0.05;
constexpr double near_voxels = 2.0;  // lines that are further apart are two lines

struct CorePoint {
  Vec3 at_m;
  Vec3 axis;
};

struct Flow {
  FieldPtr velocity, q, smooth_velocity, pressure, fluid;
  GridGeometry geometry;
  double voxel_m;
  double threshold;

  /// In the fluid, two voxels about: beside the wing the derivatives are those of its surface.
  bool in_fluid(const Vec3& x) const {
    for (const double a : {-2.0, 0.0, 2.0}) {
      for (const double b : {-2.0, 0.0, 2.0}) {
        for (const double c : {-2.0, 0.0, 2.0}) {
          const ScalarSample s = fluid->scalar(x + voxel_m * Vec3{a, b, c});
          if (!s.inside || s.value < 0.99) return false;
        }
      }
    }
    return true;
  }
  bool felt(const Vec3& x) const {
    const ScalarSample s = q->scalar(x);
    return s.inside && s.value >= threshold && in_fluid(x);
  }
};

Flow flow_of(const Volume& volume) {
  Flow flow;
  for (const VolumeField& field : volume.fields) {
    if (field.name == "velocity") flow.velocity = field.field;
    if (field.name == "pressure") flow.pressure = derived(Derivation::smooth, field.field);
    if (field.name == "fluid") flow.fluid = field.field;
  }
  if (!flow.velocity || !flow.pressure || !flow.fluid) throw LoadError("wing.vti has no velocity, pressure and fluid");
  const GridView* grid = grid_of(*flow.velocity);
  if (!grid) throw LoadError("wing.vti is no grid");
  flow.geometry = grid->geometry;
  flow.voxel_m = flow.velocity->spacing_m();
  flow.q = derived(Derivation::q, flow.velocity);
  flow.smooth_velocity = derived(Derivation::smooth_vector, flow.velocity);
  flow.threshold = 0.0;
  const auto& dims = flow.geometry.dims;
  double largest = 0.0;
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        const Vec3 x = flow.geometry.to_world({double(i), double(j), double(k)});
        const ScalarSample s = flow.q->scalar(x);
        if (s.inside && s.value > largest && flow.in_fluid(x)) largest = s.value;
      }
    }
  }
  flow.threshold = threshold_share * largest;
  return flow;
}

/// Looks through vortex_line from one place.
class Line {
 public:
  explicit Line(const Flow& flow) : fields_{flow.q, flow.smooth_velocity}, samples_(fields_, {}) {
    mode_.field = {"q", 0};
    mode_.velocity = {"velocity", 1};
    mode_.strength_n = Strength(FieldRef{"q", 0}, TransferFunction({{0.0, 1.0}}, 1.0));
  }
  /// The core from x; false where nothing is placed.
  bool from(const Vec3& x, CorePoint& core) {
    ModeContext here(samples_, x, {}, {});
    here.proxy_m = here.probe_m = x;
    here.time_step_s = 1e-3;
    here.stiffness_n_per_m = 500;
    out_.clear(x);
    mode_.place(here, out_);
    if (out_.empty()) return false;
    core = {out_[0].position_m, out_[0].direction};
    return true;
  }

 private:
  std::vector<FieldPtr> fields_;
  Samples samples_;
  VortexLine mode_;
  PrimitiveSet out_;
};

std::vector<CorePoint> our_cores(const Flow& flow, std::size_t& seeds, std::size_t& lost) {
  std::vector<CorePoint> cores;
  Line line(flow);
  const auto& dims = flow.geometry.dims;
  seeds = lost = 0;
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        Vec3 x = flow.geometry.to_world({double(i), double(j), double(k)});
        if (!flow.felt(x)) continue;
        ++seeds;
        bool rests = false;
        CorePoint core;
        for (int step = 0; step < 60 && !rests; ++step) {
          if (!flow.felt(x) || !line.from(x, core)) break;
          const Vec3 move = shortened(core.at_m - x, flow.voxel_m);
          x += move;
          rests = norm(move) < 0.01 * flow.voxel_m;
        }
        if (rests) {
          cores.push_back({x, core.axis});
        } else {
          ++lost;
        }
      }
    }
  }
  return cores;
}

/// VTK's core lines of a velocity at the nodes, as pieces between neighbouring points, where Q is as large as ours has to be.
std::vector<std::pair<Vec3, Vec3>> vtk_cores(const Flow& flow, const Field& velocity, bool higher_order) {
  const auto& g = flow.geometry;
  vtkNew<vtkImageData> image;
  image->SetDimensions(int(g.dims[0]), int(g.dims[1]), int(g.dims[2]));
  image->SetOrigin(0, 0, 0);
  const Mat3 steps = transposed(g.index_to_world_m);
  image->SetSpacing(norm(steps.row[0]), norm(steps.row[1]), norm(steps.row[2]));
  vtkNew<vtkDoubleArray> values;
  values->SetName("velocity");
  values->SetNumberOfComponents(3);
  values->SetNumberOfTuples(image->GetNumberOfPoints());
  vtkIdType at = 0;
  for (std::int64_t k = 0; k < g.dims[2]; ++k) {
    for (std::int64_t j = 0; j < g.dims[1]; ++j) {
      for (std::int64_t i = 0; i < g.dims[0]; ++i) {
        const Vec3 u = velocity.vector(g.to_world({double(i), double(j), double(k)})).value;
        values->SetTuple3(at++, u.x, u.y, u.z);
      }
    }
  }
  image->GetPointData()->SetVectors(values);
  vtkNew<vtkVortexCore> filter;
  filter->SetInputData(image);
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "velocity");
  filter->SetHigherOrderMethod(higher_order);
  filter->Update();
  vtkPolyData* lines = filter->GetOutput();
  std::vector<std::pair<Vec3, Vec3>> pieces;
  vtkNew<vtkIdList> ids;
  const auto point = [&](vtkIdType id) {
    double p[3];
    lines->GetPoint(id, p);
    return g.to_world({p[0] / image->GetSpacing()[0], p[1] / image->GetSpacing()[1], p[2] / image->GetSpacing()[2]});
  };
  for (vtkIdType c = 0; c < lines->GetNumberOfCells(); ++c) {
    lines->GetCellPoints(c, ids);
    for (vtkIdType i = 0; i + 1 < ids->GetNumberOfIds(); ++i) {
      const Vec3 a = point(ids->GetId(i)), b = point(ids->GetId(i + 1));
      if (flow.felt(0.5 * (a + b))) pieces.emplace_back(a, b);
    }
  }
  return pieces;
}

double distance_to_piece_m(const Vec3& x, const std::pair<Vec3, Vec3>& piece) {
  const Vec3 along = piece.second - piece.first;
  const double length = norm_squared(along);
  const double t = length > 0.0 ? std::clamp(dot(x - piece.first, along) / length, 0.0, 1.0) : 0.0;
  return distance(x, piece.first + t * along);
}

/// From a place on a core to the minimum of pressure in the plane across the axis, by guarded Newton steps.
bool pressure_minimum(const Flow& flow, const CorePoint& core, Vec3& found) {
  const Vec3 side = std::abs(core.axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 e1 = normalized(cross(core.axis, side)), e2 = cross(core.axis, e1);
  found = core.at_m;
  for (int step = 0; step < 40; ++step) {
    const ScalarSample p = flow.pressure->scalar(found);
    if (!p.inside) return false;
    const Mat3 h = flow.pressure->hessian(found);
    const double g1 = dot(e1, p.gradient), g2 = dot(e2, p.gradient);
    const double a = dot(e1, h * e1), b = dot(e1, h * e2), c = dot(e2, h * e2), det = a * c - b * b;
    if (!(a + c > 0.0) || !(det > 0.0)) return false;
    const Vec3 move = ((b * g2 - c * g1) / det) * e1 + ((b * g1 - a * g2) / det) * e2;
    found += shortened(move, 0.5 * flow.voxel_m);
    if (distance(found, core.at_m) > 3.0 * flow.voxel_m) return false;
    if (norm(move) < 1e-3 * flow.voxel_m) return true;
  }
  return false;
}

double share_of(std::vector<double>& values, double share) {
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : palpa::detail::quantile(values, share);
}

void compare(const Flow& flow, const std::vector<CorePoint>& ours, const std::vector<std::pair<Vec3, Vec3>>& theirs,
             const char* name) {
  std::vector<double> apart, ours_to_pressure, theirs_to_pressure;
  double only_vtk_m = 0.0, vtk_m = 0.0;
  for (const auto& piece : theirs) {
    const Vec3 middle = 0.5 * (piece.first + piece.second);
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const CorePoint& core : ours) {
      // To the line through the core point, as far as half a voxel along it.
      const Vec3 d = middle - core.at_m;
      if (norm_squared(d) > 16.0 * flow.voxel_m * flow.voxel_m) continue;
      const double along = std::clamp(dot(d, core.axis), -0.5 * flow.voxel_m, 0.5 * flow.voxel_m);
      nearest_m = std::min(nearest_m, norm(d - along * core.axis));
    }
    const double length_m = distance(piece.first, piece.second);
    vtk_m += length_m;
    if (nearest_m > near_voxels * flow.voxel_m) {
      only_vtk_m += length_m;
      continue;
    }
    apart.push_back(nearest_m / flow.voxel_m);
  }
  std::size_t only_ours = 0;
  for (const CorePoint& core : ours) {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const auto& piece : theirs) nearest_m = std::min(nearest_m, distance_to_piece_m(core.at_m, piece));
    Vec3 minimum;
    const bool judged = pressure_minimum(flow, core, minimum);
    if (nearest_m > near_voxels * flow.voxel_m) {
      ++only_ours;
      continue;
    }
    if (!judged) continue;
    double theirs_m = std::numeric_limits<double>::infinity();
    for (const auto& piece : theirs) theirs_m = std::min(theirs_m, distance_to_piece_m(minimum, piece));
    ours_to_pressure.push_back(distance(core.at_m, minimum) / flow.voxel_m);
    theirs_to_pressure.push_back(theirs_m / flow.voxel_m);
  }
  std::printf("%s\n", name);
  std::printf("  pieces of VTK's lines where Q is large enough            %zu, %.1f voxels long together\n", theirs.size(),
              vtk_m / flow.voxel_m);
  std::printf("  distance of the felt core and VTK's line [voxels]        median %.3f, p90 %.3f\n", share_of(apart, 0.5),
              share_of(apart, 0.9));
  std::printf("  share of VTK's length where no core is felt              %.1f %%\n", 100.0 * only_vtk_m / vtk_m);
  std::printf("  share of felt core points without a line of VTK          %.1f %%\n",
              100.0 * double(only_ours) / double(ours.size()));
  std::printf("  to the minimum of pressure [voxels], %5zu places         ours %.3f, p90 %.3f; VTK's %.3f, p90 %.3f\n",
              ours_to_pressure.size(), share_of(ours_to_pressure, 0.5), share_of(ours_to_pressure, 0.9),
              share_of(theirs_to_pressure, 0.5), share_of(theirs_to_pressure, 0.9));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s DATA_FOLDER\n", argv[0]);
    return 2;
  }
  try {
    const Flow flow = flow_of(read_volume(std::filesystem::path(argv[1]) / "cfd_wing" / "wing.vti"));
    std::size_t seeds = 0, lost = 0;
    const std::vector<CorePoint> ours = our_cores(flow, seeds, lost);
    std::printf("felt where Q >= %.4g /s²: %zu voxels, %zu lead to a core, %zu out of what is felt\n", flow.threshold, seeds,
                ours.size(), lost);
    compare(flow, ours, vtk_cores(flow, *flow.velocity, true), "VTK, higher order, the velocity of the file");
    compare(flow, ours, vtk_cores(flow, *flow.velocity, false),
            "VTK, first order (Sujudi and Haimes), the velocity of the file");
    compare(flow, ours, vtk_cores(flow, *flow.smooth_velocity, true), "VTK, higher order, the velocity smoothed as ours is");
    return 0;
  } catch (const LoadError& error) {
    std::fprintf(stderr, "bench_vortex_core: %s\n", error.what());
    return 2;
  }
}
