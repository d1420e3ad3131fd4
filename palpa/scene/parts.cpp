#include "palpa/scene/parts.h"

#include <limits>

#include "palpa/base/limits.h"
#include "palpa/baseline/law.h"
#include "palpa/data/analytic.h"
#include "palpa/data/length_unit.h"

namespace palpa {

namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();
constexpr Range positive{0, unbounded, true};

using Words = std::span<const std::string_view>;
template <std::size_t N>
using WordList = std::array<std::string_view, N>;

constexpr WordList<12> directions{"anterior", "posterior", "left", "right", "superior", "inferior",
                                  "+x",       "-x",        "+y",   "-y",    "+z",       "-z"};
constexpr WordList<1> vector_word{"vector"};
constexpr WordList<2> components_along{"file", "index"};
constexpr WordList<1> latest{"latest"};
constexpr WordList<10> voxel_types{"int8",   "uint8", "int16",  "uint16",  "int32",
                                   "uint32", "int64", "uint64", "float32", "float64"};
constexpr WordList<2> byte_orders{"little", "big"};
constexpr WordList<18> axis_orders{"xyz",  "xzy",  "yxz",  "yzx",  "zxy",  "zyx",  "txyz", "txzy", "tyxz",
                                   "tyzx", "tzxy", "tzyx", "xyzt", "xzyt", "yxzt", "yzxt", "zxyt", "zyxt"};
constexpr WordList<2> component_places{"first", "last"};
constexpr WordList<1> no_sign{"none"};
constexpr std::array shapes{"point", "points", "rod", "pad", "ball"};  // of ToolOptions::Shape

Words analytic_names() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> all;
    for (const auto& volumes : {analytic_volumes(), beating_volumes()}) {
      for (const AnalyticVolume& volume : volumes) all.push_back(volume.name);
    }
    return all;
  }();
  return names;
}

/// Key whose value the reader of the part checks by itself.
constexpr ParameterInfo other(std::string_view name, ParameterKind kind, std::string_view form, std::string_view sentence,
                              bool needed = false) {
  return {.name = name, .sentence = sentence, .kind = kind, .form = form, .needed = needed};
}

template <class Part, class... Entries>
void each(Part& part, ParameterVisitor& visitor, const Entries&... entries) {
  (detail::visit_parameter(part, entries, visitor), ...);
}

/// Box in the file's order: low corner, then high corner.
struct Crop {
  std::optional<std::array<double, 6>> m;
};

void visit_layout(ArrayLayout& part, ParameterVisitor& visitor) {
  using A = ArrayLayout;
  each(part, visitor,
       param("type", &A::type, "of a file of bare numbers: what they are; `dims` says how many", Words(voxel_types)),
       param("byte_order", &A::byte_order, "of bare numbers", Words(byte_orders)).left_out("\"little\""),
       param("header_bytes", &A::header_bytes, "before the first of bare numbers", Range{0, 1e15}),
       param("dims", &A::dims, "voxels along each axis, of bare numbers; of an array in HDF5 to be checked", Range{1, 1e9})
           .written("[x, y, z]"),
       param("axes", &A::axes, "the axes that the indices of an array are along, slowest first; t: time, of HDF5",
             Words(axis_orders))
           .left_out("\"zyx\""),
       param("components", &A::components, "which index of an array is that of vector components", Words(component_places))
           .left_out("last, if it is of 3; of bare numbers none"),
       param("spacing_m", &A::spacing_m, "distances of an array's voxels along each axis").left_out("1, 1, 1"),
       param("origin_m", &A::origin_m, "where the first voxel of an array lies").left_out("0, 0, 0"));
}

}  // namespace

namespace detail {

std::vector<std::string> direction_words() { return {directions.begin(), directions.end()}; }

}  // namespace detail

void visit_part(detail::HeaderPart& part, ParameterVisitor& visitor) {
  using H = detail::HeaderPart;
  using Kind = ParameterKind;
  each(part, visitor, param("palpa", &H::palpa, "format of the scene file", Range{1, 1}).written("1").needed(),
       param("title", &H::title, "what the scene is, in one line"),
       param("needs", &H::needs, "types of modes that plug-ins must bring"),
       other("coupling", Kind::table, "[coupling]", "the spring between hand and proxy"),
       other("law", Kind::table, "[law]", "the rule that finds the balance"),
       other("workspace", Kind::table, "[workspace]", "how the hand's reach lies in the world"),
       other("time", Kind::table, "[time]", "how the time goes of data that change with it"),
       other("tool", Kind::table, "[tool]", "where the tool in the hand touches the data; without it a point does"),
       other("hand", Kind::list, "[[hand]]", "instead of `tool`: several hands, one table for each, with a tool of its own"),
       param("only_hand", &H::only_hand, "of several hands only this one").written("name of a [[hand]]").left_out("all"),
       other("volume", Kind::table, "[volume.NAME]", "the data, one table for each volume; NAME is a plain word"),
       other("mode", Kind::list, "[[mode]]", "what is felt, one table for each mode; at least one"),
       other("view", Kind::table, "[[view.layer]]", "how it is drawn; ignored where nothing is drawn"));
}

void visit_part(CouplingOptions& part, ParameterVisitor& visitor) {
  using C = CouplingOptions;
  each(part, visitor,
       param("stiffness_n_per_m", &C::stiffness_n_per_m,
             "stiffness of the spring that pulls the hand to the proxy (k of Eq. 1)", Range{0, 1e5, true}),
       param("damping_ns_per_m", &C::damping_ns_per_m, "damping of that spring (D of Eq. 1)", Range{0, 100}),
       param("max_force_n", &C::max_force_n, "the guard lets out no longer force than this", Range{0, 100, true}),
       param("impact_ns_per_m", &C::impact_ns_per_m,
             "pulse of 20 ms as a hard level is hit, by the speed of the impact; added to what the data say; 0: none",
             Range{0, 100}),
       param("max_torque_nm", &C::max_torque_nm, "with a tool: the guard lets out no larger torque than this",
             Range{0, 10, true}),
       param("turn_damping_nms_per_rad", &C::turn_damping_nms_per_rad, "with a tool: damping of the spring against turning",
             Range{0, 1})
           .left_out("`damping_ns_per_m` times `turning_radius_m` squared"));
}

void visit_part(detail::LawPart& part, ParameterVisitor& visitor) {
  each(part, visitor, param("method", &detail::LawPart::method, "which law finds the balance", Words(baseline::law_names)));
}

void visit_part(Workspace& part, ParameterVisitor& visitor) {
  using W = Workspace;
  each(part, visitor,
       volume_param("fit", &W::fit, "the longest side of this volume's box becomes 0.15 m of hand, on every device")
           .left_out("the first volume, unless `scale` is given"),
       param("scale", &W::scale, "instead of `fit`: world metres per hand metre", positive),
       volume_param("center", &W::center_volume,
                    "what the middle of the hand's reach touches: the middle of a volume's box, or a world position [m]")
           .written("volume or [x, y, z]")
           .left_out("the box of `fit`"),
       param("center", &W::center_m, "the same as a position"),
       param("towards_user", &W::towards_user, "world direction that faces the user", Words(directions))
           .written("direction")
           .left_out("\"anterior\" in a medical frame, else \"+z\""),
       param("up", &W::up, "world direction that is up", Words(directions))
           .written("direction")
           .left_out("\"superior\" in a medical frame, else \"+y\""));
}

void visit_part(TimeOptions& part, ParameterVisitor& visitor) {
  using T = TimeOptions;
  each(part, visitor,
       choice_param("play", &T::play,
                    "the data stay at `start_s`, go on to their end, or begin again, each volume after its own length", "hold",
                    "once", "loop"),
       param("speed", &T::speed, "seconds of data per second", Range{0, 1000, true}),
       param("start_s", &T::start_s, "the moment of the data that is felt first [s]", Range{0, 1e9}));
}

const char* name_of(ToolOptions::Shape shape) noexcept { return shapes[static_cast<std::size_t>(shape)]; }

void visit_part(ToolOptions& part, ParameterVisitor& visitor) {
  using T = ToolOptions;
  each(part, visitor,
       param("points_m", &T::points_m, "the feet themselves, within 1 m, in the axes of the handle and in metres of the hand"));
  // Points need no word for their shape; one that is given decides.
  if (!part.points_m.empty() && part.shape == T::Shape::point) part.shape = T::Shape::points;
  each(part, visitor,
       choice_param("shape", &T::shape,
                    "one foot at the device's point; those of `points_m`; a rod along z, with a radius a cylinder; a disc "
                    "across z; a sphere",
                    shapes[0], shapes[1], shapes[2], shapes[3], shapes[4])
           .left_out("\"points\" with `points_m`, else \"point\""),
       param("length_m", &T::length_m, "of a rod", Range{0, 1}),
       param("radius_m", &T::radius_m, "of a pad, a ball or a rod", Range{0, 0.5}),
       param("points", &T::points, "how many feet a rod, pad or ball has", Range{1, limit::tool_feet.most}),
       param("share", &T::share, "how much of each strength and drag a foot bears; of a pad often one through its feet",
             Range{0, 1, true}),
       param("centre_m", &T::centre_m, "where in the shape the device's point is, which force and torque act on"),
       param("turning_radius_m", &T::turning_radius_m,
             "the spring against turning is `stiffness_n_per_m` times this squared; below 1e-6 as 1e-6", Range{0, 1, true})
           .left_out("from levers, stiffness and `max_force_n`, so that no press tips the tool over"));
}

void visit_part(SceneHand& part, ParameterVisitor& visitor) {
  each(part, visitor,
       param("name", &SceneHand::name, "what the hand is called: in --hand NAME=…, its folder of a trace, --set; unique")
           .written("plain word")
           .needed(),
       param("at_m", &SceneHand::at_m,
             "where the middle of its reach lies in the hand frame of the workspace: right, up, towards the user; within 1 m"),
       other("tool", ParameterKind::table, "[hand.tool]", "its tool, with the keys of [tool]; without it a point"));
}

void visit_part(detail::VolumePart& part, ParameterVisitor& visitor) {
  using V = detail::VolumePart;
  each(
      part, visitor,
      param("file", &V::file,
            "the file, several that belong together (PLOT3D), the folder of a case (OpenFOAM) or of a store (Zarr), the web "
            "address of a store, or an array in a file "
            "(\"flow.h5:/velocity\"); a relative path is looked for beside the scene, then in each --data folder, "
            "then in $PALPA_DATA")
          .written("path, or [path, …]"),
      param("file", &V::files, "the same as a list"),
      param("files", &V::series,
            "instead of `file`: a time series, one file for each frame; `*` and `?` in the name stand for any characters, and "
            "numbers in it sort by value")
          .written("pattern of paths"),
      param("frame_period_s", &V::frame_period_s,
            "time from frame to frame of a series; with `file`, all the frames that it holds are one", Range{0, 1e9, true})
          .written("number [s], above 0")
          .left_out("that of `analytic`"),
      choice_param("between_frames", &V::between_frames, "what lies between two frames: their blend, or the nearer one",
                   "linear", "nearest"),
      param("analytic", &V::analytic, "instead of `file`: embedded data", analytic_names()),
      param("sampled", &V::sampled,
            "with `analytic`: as a grid with this many samples along its longest side, instead of a formula",
            Range{2, limit::sampled_side.most}),
      param("frames", &V::frames,
            "with `sampled`, of embedded data that change with time: in how many moments of their cycle they are sampled",
            Range{1, limit::sampled_frames.most}),
      table_param("pose", &V::pose, "moves the volume in the world")
          .written("{translate_m, rotate_axis_deg, scale}")
          .left_out("where the file puts it"),
      list_param("poses", &V::poses,
                 "instead of `pose`: where the volume is at some moments; it moves steadily from one to the next")
          .written("[{time_s, translate_m, rotate_axis_deg, scale}, …]"),
      choice_param("filter", &V::filter,
                   "what lies between the voxels: straight lines, a cubic spline that smooths (whole numbers lose their "
                   "steps), or one that meets the voxels (not of whole numbers)",
                   "trilinear", "smooth", "cubic")
          .left_out("smooth for whole numbers and rough scalars, cubic for smooth ones, trilinear for vectors"),
      param("sign", &V::sign, "the vectors are axes, whose sign means nothing, as the main direction of diffusion",
            Words(no_sign)),
      other("labels", ParameterKind::table, "{NAME = whole number}",
            "of a label map: more fields, each 1 where the voxels are this number and 0 elsewhere; its level 0.5 is a surface"),
      param("smoothing_m", &V::smoothing_m,
            "how far what vortex modes, gradient_force, q, lambda2 and coherence feel is smoothed first: standard deviation, "
            "in the world",
            positive)
          .left_out("two sample spacings"));
  visit_part(part.request, visitor);
}

void visit_part(VolumeRequest& part, ParameterVisitor& visitor) {
  using R = VolumeRequest;
  each(
      part, visitor,
      param("length_unit", &R::length_unit, "unit of length of a file that says none, or one that is unknown",
            Words(detail::proposed_length_units))
          .written(
              "\"m\", \"cm\", \"mm\", \"um\", \"nm\", \"km\", \"angstrom\", \"in\", \"ft\" or another, in any usual spelling")
          .left_out("the file's; else mm for medical formats, m for others"),
      named_list_param("fields", &R::fields, "which arrays of the file are fields, and what they are called")
          .written("{array = text, arrays = [x, y, z], unit = text}")
          .left_out("all, under the file's names"),
      param("frame", &R::frame, "which frame of a file that holds several, counted from 0", Range{0, 1e6}),
      param("as", &R::as, "takes a file of three frames as one vector field", Words(vector_word)),
      param("series", &R::series, "which series of a DICOM folder that holds several; `palpa info` lists them")
          .written("UID")
          .left_out("the largest"),
      param("components_along", &R::components_along,
            "the axes that the components of vectors are along: those of the file's space, or those of its grid (FSL's "
            "directions)",
            Words(components_along))
          .left_out("\"file\""),
      param("memory_mb", &R::memory_mb,
            "a store (OME-Zarr) whose finest octave takes more memory is felt through windows about the proxy", Range{0, 1e6})
          .left_out("512"),
      param("coarsest_mm", &R::coarsest_mm,
            "width [mm, in the file's frame] of the widest voxels that are felt; strengths fade where octaves would be coarser",
            positive)
          .left_out("any width"),
      param("time", &R::time_s, "which moment of a case that holds several", Range{0, unbounded}, Words(latest))
          .written("\"latest\", or number [s]")
          .left_out("\"latest\""));
  Crop crop;
  if (const auto& c = part.crop) crop.m = {c->low_m.x, c->low_m.y, c->low_m.z, c->high_m.x, c->high_m.y, c->high_m.z};
  each(crop, visitor,
       param("crop_m", &Crop::m,
             "low and high corner, in the file's frame, of the part in which a curvilinear or unstructured grid is resampled")
           .written("[x, y, z, x, y, z]")
           .left_out("all of it"));
  if (const auto& c = crop.m) part.crop = Box{{(*c)[0], (*c)[1], (*c)[2]}, {(*c)[3], (*c)[4], (*c)[5]}};
  visit_layout(part.layout, visitor);
}

void visit_part(VolumeRequest::FieldRequest& part, ParameterVisitor& visitor) {
  using F = VolumeRequest::FieldRequest;
  each(
      part, visitor, param("name", &F::name, "what scenes call it"),
      param("array", &F::array, "what the file calls the array").left_out("NAME"),
      param("arrays", &F::arrays, "three scalar arrays of the file that are the components of one vector").written("[x, y, z]"),
      param("unit", &F::unit, "label of its unit; converts nothing").left_out("the file's"));
}

void visit_part(detail::PosePart& part, ParameterVisitor& visitor) {
  using P = detail::PosePart;
  each(part, visitor, param("translate_m", &P::translate_m, "where the volume's origin goes [m], after turn and scale"),
       param("rotate_axis_deg", &P::rotate_axis_deg, "axis, and right-handed angle about it")
           .written("[x, y, z, degrees]")
           .left_out("no turn"),
       param("scale", &P::scale, "how much larger the volume becomes", positive));
}

void visit_part(detail::TimedPosePart& part, ParameterVisitor& visitor) {
  each(part, visitor,
       param("time_s", &detail::TimedPosePart::time_s, "moment of the data; the first is at 0, and they rise", Range{0, 1e9})
           .needed());
  visit_part(part.pose, visitor);
}

void visit_part(detail::ModePart& part, ParameterVisitor& visitor) {
  using M = detail::ModePart;
  each(part, visitor,
       param("name", &M::name, "what the mode is called in events, tables and --set; unique").written("plain word").needed(),
       param("type", &M::type, "one of those that `palpa modes` lists").written("type of mode").needed(),
       param("enabled", &M::enabled, "false: stays silent"),
       choice_param("feet", &M::feet, "which feet of the tool feel the mode", "all", "first")
           .left_out("all for modes with levels, else first"),
       other("mask", ParameterKind::list, "[{of, points, outside}, …]",
             "factors between 0 and 1 on all strengths and drags of the mode, as functions of a field's value"));
}

void visit_part(detail::FunctionPart& part, ParameterVisitor& visitor) {
  using F = detail::FunctionPart;
  each(part, visitor, param("of", &F::of, "scalar field whose value is looked up"),
       other("points", ParameterKind::rows, "[[value, result], …]",
             "piecewise linear; values do not fall, two equal ones make a step", true),
       param("outside", &F::outside, "result below the first and above the last value", Range{}));
}

void visit_part(ViewOptions& part, ParameterVisitor& visitor) {
  each(part, visitor, other("layer", ParameterKind::list, "[[view.layer]]", "what is drawn"),
       param("from", &ViewOptions::from, "direction of the world from which pictures look")
           .left_out("chosen for what was felt"));
}

void visit_part(ViewLayer& part, ParameterVisitor& visitor) {
  using L = ViewLayer;
  each(part, visitor,
       choice_param("show", &L::show, "how it is drawn", "surface", "slices", "volume", "streamlines", "glyphs").needed(),
       optional_field_param("field", &L::field, "what is drawn").needed(),
       param("level", &L::level, "of a surface: the value it is drawn at", Range{}),
       param("name", &L::name, "what the legend calls it").left_out("the level's or the field's"),
       choice_param("parts", &L::all_parts,
                    "of a surface that is in several parts: those that are not small beside the largest, or all", "large",
                    "all"),
       other("colors", ParameterKind::table, "{points = [[value, \"#rrggbb\", opacity], …]}", "colour and opacity by value"));
}

void visit_part(detail::ColorsPart& part, ParameterVisitor& visitor) {
  each(part, visitor, other("points", ParameterKind::rows, "[[value, \"#rrggbb\", opacity], …]", "piecewise linear", true));
}

}  // namespace palpa
