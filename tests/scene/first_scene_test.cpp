// Suggested scenes: they load, give the reason of each number, and fit their data.
#include "palpa/scene/first_scene.h"

#include <gmock/gmock.h>

#include <fstream>
#include <functional>
#include <random>
#include <regex>
#include <sstream>

#include "palpa/data/halton.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/scene/first_object.h"
#include "scene_files.h"

namespace palpa::test {
namespace first_scene_test {

using testing::HasSubstr;
using testing::Not;

/// A suggested scene, loaded with its volume, without a warning.
Scene parsed(const std::string& text, const Volume& volume) {
  const auto as_read = [&](const VolumeRequest& wanted) {
    Volume read = volume;
    if (!wanted.fields.empty()) {
      read.fields.clear();
      for (const auto& field : wanted.fields) {
        for (const VolumeField& there : volume.fields) {
          if (there.name == (field.array.empty() ? field.name : field.array))
            read.fields.push_back({field.name, "", there.field});
        }
      }
    }
    return read;
  };
  // A scene can be parsed without its file, but its loader checks for it.
  std::string here = text;
  const std::string folder = testing::TempDir();
  std::ofstream(folder + "/file.nrrd") << "x";
  here.replace(here.find("/data/file.nrrd"), 15, folder + "/file.nrrd");
  const LoadedScene loaded = parse_scene(here, "first.toml", {}, as_read, standard_modes(), {.thin_parts = true});
  EXPECT_TRUE(loaded.warnings.empty());
  return loaded.scene;
}

/// The scene for a volume, which must load.
std::string scene_of(const Volume& volume, VolumeRequest request = {}) {
  request.files = {"/data/file.nrrd"};
  const std::string text = first_scene(volume, request);
  parsed(text, volume);
  return text;
}

Volume sampled_head() {
  Volume head = sampled(head_phantom(), 60);
  head.fields[0].unit = "";
  return head;
}

TEST(FirstScene, OfCtFeelsSkinAndBone) {
  const std::string text = scene_of(sampled_head());
  for (const char* part : {"value = -300", "value = 300", "-1000 HU", "solid = \"high\"", "viscosity"})
    EXPECT_THAT(text, HasSubstr(part));
}

TEST(FirstScene, SaysWhyOfEveryNumber) {
  for (const Volume& volume : {sampled_head(), ring_vortex(), sphere_field()}) {
    std::istringstream lines(scene_of(volume));
    for (std::string line; std::getline(lines, line);) {
      if (!std::regex_search(line, std::regex("= .*[0-9]")) || line.starts_with("palpa = ") || line.starts_with("file = "))
        continue;
      EXPECT_THAT(line, HasSubstr("# ")) << "no reason";
    }
  }
}

TEST(FirstScene, OfAVectorFieldFollowsItWhereItFlows) {
  const std::string text = scene_of(ring_vortex());
  for (const char* part : {"type = \"follow\"", "type = \"viscosity\"", "magnitude(file.velocity)", "mask = "})
    EXPECT_THAT(text, HasSubstr(part));
}

TEST(FirstScene, TakesNoScanForACtThatItsFileSaysIsNone) {
  const auto skin = HasSubstr("name = \"skin\""), bone = HasSubstr("name = \"bone\""), hounsfield = HasSubstr("Hounsfield");
  Volume head = sampled_head();
  for (const char* modality : {"", "CT"}) {
    head.modality = modality;
    EXPECT_THAT(scene_of(head), testing::AllOf(skin, bone, hounsfield)) << modality;
  }
  for (const char* modality : {"MR", "PT", "NM", "US"}) {
    head.modality = modality;
    EXPECT_THAT(scene_of(head), testing::AllOf(Not(skin), Not(bone), Not(hounsfield))) << modality;
  }
  head.modality = "";
  head.fields[0].unit = "rad";
  EXPECT_THAT(scene_of(head), testing::AllOf(Not(skin), Not(bone), Not(hounsfield)));
}

TEST(FirstScene, NeverTakesAUnitInSilence) {
  Volume head = sampled_head();
  head.length_unit = "mm", head.length_unit_assumed = true;
  // As a comment: `run` repeats an assumption until the key is written.
  EXPECT_THAT(scene_of(head), HasSubstr("\n# length_unit = \"mm\""));
  EXPECT_THAT(scene_of(head), HasSubstr("ASSUMED"));
  head.length_unit_assumed = false;
  EXPECT_THAT(scene_of(head), Not(HasSubstr("length_unit")));
  VolumeRequest request;
  request.length_unit = "cm";
  head.length_unit = "cm";
  EXPECT_THAT(scene_of(head, request), HasSubstr("length_unit = \"cm\""));
}

TEST(FirstScene, NamesFieldsByPlainWords) {
  Volume two = sampled_head();
  two.fields[0].name = "1st array (raw)";
  two.fields.push_back({"other", "", two.fields[0].field});
  EXPECT_THAT(scene_of(two), HasSubstr("fields = {value = {array = \"1st array (raw)\"}}"));
  two.fields[0].name = "my array";
  EXPECT_THAT(scene_of(two), HasSubstr("fields = {my_array = {array = \"my array\"}}"));
}

TEST(FirstScene, SaysAllThatTheFileWasReadBy) {
  VolumeRequest request;
  request.files = {"/data/file.xyz", "/data/other.q"};
  request.fields = {{"speed", "velocity magnitude", "m/s"}};
  request.series = "1.2.3";
  request.components_along = "index";
  request.time_s = 0.5;
  request.crop = Box{{0, 0, 0}, {1, 2, 3}};
  request.layout = {.type = "int16",
                    .byte_order = "big",
                    .header_bytes = 8,
                    .axes = "xyz",
                    .components = "last",
                    .dims = {4, 5, 6},
                    .spacing_m = {1, 2, 3},
                    .origin_m = Vec3{-1, 0, 1}};
  Volume volume = sampled_head();
  volume.fields[0].name = "speed";
  const auto again = [&](const std::string& text) {
    std::optional<VolumeRequest> asked;
    const auto note = [&](const VolumeRequest& wanted) {
      asked = wanted;
      return volume;
    };
    std::string here = text;
    const std::string folder = testing::TempDir();
    for (const char* file : {"/file.xyz", "/other.q"}) {
      std::ofstream(folder + file) << "x";
      here.replace(here.find("/data" + std::string(file)), 5 + std::string(file).size(), folder + file);
    }
    parse_scene(here, "first.toml", {}, note, standard_modes());
    return *asked;
  };
  Scene code;
  code.add("fluid", Viscosity{.drag_ns_per_m = 1.0});
  Volume read = volume;
  read.files = {{"/data/file.xyz", 1, "0"}, {"/data/other.q", 1, "0"}};
  read.request = std::make_shared<const VolumeRequest>(request);
  code.add("data", read);
  for (const std::string& text : {first_scene(volume, request), to_toml(code)}) {
    SCOPED_TRACE(text);
    const VolumeRequest asked = again(text);
    ASSERT_EQ(asked.files.size(), 2U);
    EXPECT_EQ(asked.files[1].filename(), "other.q");
    ASSERT_EQ(asked.fields.size(), 1U);
    EXPECT_EQ(asked.fields[0].name, "speed");
    EXPECT_EQ(asked.fields[0].array, "velocity magnitude");
    EXPECT_EQ(asked.fields[0].unit, "m/s");
    EXPECT_EQ(asked.series, request.series);
    EXPECT_EQ(asked.components_along, request.components_along);
    EXPECT_EQ(asked.time_s, request.time_s);
    ASSERT_TRUE(asked.crop);
    EXPECT_EQ(asked.crop->high_m, request.crop->high_m);
    EXPECT_EQ(asked.layout, request.layout);
  }
}

TEST(FirstScene, NamesTheArraysThatAVectorIsMadeOf) {
  VolumeRequest request;
  request.fields = {{"velocity", "", "", {"u", "v", "w"}}};
  Volume volume = ring_vortex();
  volume.fields.resize(1);
  EXPECT_THAT(scene_of(volume, request), HasSubstr("fields = {velocity = {arrays = [\"u\", \"v\", \"w\"]}}"));
}

TEST(FirstScene, OfPartsOfACtAndOfSparseFlowsCanBeLoaded) {
  const auto volume = [](const std::string& unit, int components, const std::function<double(int)>& value) {
    const auto data = std::make_shared<std::vector<float>>();
    for (int n = 0; n < 20 * 20 * 20 * components; ++n) data->push_back(static_cast<float>(value(n)));
    Volume made;
    made.fields = {
        {"v", unit,
         grid_field({{20, 20, 20}, 1e-3 * Mat3::identity(), {}}, {VoxelType::float32, components, {data, data->data()}})}};
    return made;
  };
  EXPECT_THAT(scene_of(volume("HU", 1, [](int n) { return n % 1000; })), Not(HasSubstr("name = \"skin\"")));
  scene_of(volume("HU", 1, [](int n) { return -320 + n % 100; }));
  scene_of(volume("HU", 1, [](int n) { return -1000 + n % 701; }));
  scene_of(volume("", 1, [](int n) { return 1e6 + n % 2; }));
  scene_of(volume("", 1, [](int n) { return n % 4000 == 0 ? 1.0 : 0.0; }));
  // Eight of 8000 voxels move, and in one flow only an outlier is large.
  const std::string sparse = scene_of(volume("", 3, [](int n) { return n % 3000 == 0 ? 2.0 : 0.0; }));
  EXPECT_THAT(sparse, HasSubstr("points = [[0.1, 0], [2, 0.15]"));
  scene_of(volume("", 3, [](int n) { return n == 0 ? 1e9 : 1e-6 * (n % 7); }));
}

TEST(FirstScene, OfMedicalDataShowsTheFace) {
  EXPECT_THAT(scene_of(sampled_head()), HasSubstr("\"anterior\""));
  EXPECT_THAT(scene_of(sphere_field()), HasSubstr("\"+z\""));
}

TEST(FirstScene, OfNothingToFeelIsRefused) {
  const auto zeros = std::make_shared<std::vector<float>>(27, 4.0F);
  Volume flat;
  flat.fields = {{"flat", "", grid_field({{3, 3, 3}, Mat3::identity(), {}}, {VoxelType::float32, 1, {zeros, zeros->data()}})}};
  EXPECT_THROW(scene_of(flat), LoadError);
}

TEST(FirstScene, LooksAtVectorsFirstAndLeavesOutWhatIsConstant) {
  Volume volume = ring_vortex();
  std::vector<Statistics> values;
  for (const VolumeField& field : volume.fields) values.push_back(statistics(*field.field));
  const auto chosen = field_to_feel(volume, values);
  ASSERT_TRUE(chosen);
  EXPECT_EQ(volume.fields[*chosen].field->components(), 3);
  for (Statistics& v : values) v.min = v.max = 0.0;
  EXPECT_FALSE(field_to_feel(volume, values));
}

// ---- The whole of the object

/// A scalar field on a grid of cubes, from a formula of the position [m].
Volume scalar_grid(int n, double spacing_m, const Vec3& origin_m, const std::function<double(const Vec3&)>& value) {
  const auto data = std::make_shared<std::vector<float>>();
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        data->push_back(static_cast<float>(value(origin_m + spacing_m * Vec3{1.0 * i, 1.0 * j, 1.0 * k})));
  Volume made;
  made.fields = {
      {"v", "",
       grid_field({{n, n, n}, spacing_m * Mat3::identity(), origin_m}, {VoxelType::float32, 1, {data, data->data()}})}};
  return made;
}

/// A vector field likewise.
Volume vector_grid(int n, double spacing_m, const std::function<Vec3(const Vec3&)>& value) {
  const auto data = std::make_shared<std::vector<float>>();
  const Vec3 origin_m = -0.5 * spacing_m * (n - 1) * Vec3{1, 1, 1};
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const Vec3 v = value(origin_m + spacing_m * Vec3{1.0 * i, 1.0 * j, 1.0 * k});
        for (const double c : {v.x, v.y, v.z}) data->push_back(static_cast<float>(c));
      }
  Volume made;
  made.fields = {
      {"velocity", "m/s",
       grid_field({{n, n, n}, spacing_m * Mat3::identity(), origin_m}, {VoxelType::float32, 3, {data, data->data()}})}};
  return made;
}

/// Numbers after a key at the beginning of a line: `scale = 1.5`, `center = [1, 2, 3]`; none without the key.
std::vector<double> numbers_of(const std::string& text, const std::string& key) {
  std::vector<double> found;
  const std::size_t at = text.find("\n" + key + " = ");
  if (at == std::string::npos) return found;
  const std::string value = text.substr(at + key.size() + 4, text.find('#', at) - at - key.size() - 4);
  const std::regex number("-?[0-9.]+(e[-+]?[0-9]+)?");
  for (std::sregex_iterator n(value.begin(), value.end(), number), end; n != end; ++n) found.push_back(std::stod(n->str()));
  return found;
}

constexpr double hand_m = 0.15;

TEST(FirstScene, ShowsTheWholeObjectAndNotItsEmptyMargins) {
  // An ellipsoid of 60 x 40 x 30 mm about (20, 10, 50) mm; beside it a plate, a tenth of its volume, and specks.
  const Vec3 centre_m{0.02, 0.01, 0.05}, half_m{0.03, 0.02, 0.015};
  for (const double scale : {1.0, 1024.0}) {
    for (const Vec3& shift_m : {Vec3{}, Vec3{0.25, -1.5, 3.0}}) {
      const auto value = [&](const Vec3& at_m) {
        const Vec3 x = at_m / scale - shift_m, from = x - centre_m;
        const bool plate = std::abs(x.y + 0.03) < 0.0021 && std::abs(x.x - 0.02) < 0.02 && std::abs(x.z - 0.05) < 0.006;
        const bool speck = distance(x, {-0.025, 0.05, 0.02}) < 0.0016;
        return norm({from.x / half_m.x, from.y / half_m.y, from.z / half_m.z}) < 1.0 || plate || speck ? 100.5 : 0.0;
      };
      const Volume volume = scalar_grid(97, scale * 0.00125, scale * (Vec3{-0.04, -0.06, -0.01} + shift_m), value);
      const std::string text = scene_of(volume);
      const double cell_m = 0.12 / detail::Lattice::longest;
      ASSERT_EQ(numbers_of(text, "scale").size(), 1U) << text;
      EXPECT_NEAR(hand_m * numbers_of(text, "scale")[0] / scale, 2.0 * half_m.x, 2.0 * cell_m);
      const std::vector<double> centre = numbers_of(text, "center");
      ASSERT_EQ(centre.size(), 3U);
      EXPECT_LT(distance(Vec3{centre[0], centre[1], centre[2]} / scale, centre_m + shift_m), cell_m);
      EXPECT_THAT(text, HasSubstr("# A close-up of the first contact"));
    }
  }
}

TEST(FirstScene, FacesTheLargestSideOfTheObject) {
  // One slab of 80 x 50 x 20 mm, turned; medical data show the face, slabs of slices are viewed from the feet.
  const auto slab = [](const Vec3& half_m, bool medical) {
    Volume volume = scalar_grid(49, 0.0025, {-0.06, -0.06, -0.06}, [&](const Vec3& x) {
      return std::abs(x.x) < half_m.x && std::abs(x.y) < half_m.y && std::abs(x.z) < half_m.z ? 1.0 : 0.0;
    });
    volume.medical_frame = medical;
    const std::string text = scene_of(volume);
    return text.substr(text.find("towards_user = ") + 15, 12);
  };
  EXPECT_THAT(slab({0.04, 0.025, 0.01}, false), HasSubstr("\"+z\""));
  EXPECT_THAT(slab({0.04, 0.01, 0.025}, false), HasSubstr("\"-y\""));
  EXPECT_THAT(slab({0.01, 0.04, 0.025}, false), HasSubstr("\"+x\""));
  EXPECT_THAT(slab({0.04, 0.025, 0.01}, true), HasSubstr("\"inferior\""));
  EXPECT_THAT(slab({0.04, 0.01, 0.025}, true), HasSubstr("\"anterior\""));
}

TEST(FirstScene, TakesAHeadRestForTheBack) {
  for (const double back : {-1.0, 1.0}) {
    const Volume ct = scalar_grid(65, 0.0035, {-0.112, -0.112, -0.112}, [&](const Vec3& x) {
      const bool rest = std::abs(back * x.y - 0.1) < 0.005 && std::abs(x.x) < 0.06;
      return norm({x.x / 0.07, x.y / 0.08, x.z / 0.09}) < 0.8   ? 900.0
             : norm({x.x / 0.07, x.y / 0.08, x.z / 0.09}) < 1.0 ? 40.0
             : rest                                             ? 100.0
                                                                : -1000.0;
    });
    Volume scan = ct;
    scan.format = "nrrd";
    const std::string text = scene_of(scan);
    EXPECT_THAT(text, HasSubstr(back < 0 ? "towards_user = \"+y\"" : "towards_user = \"-y\""));
    EXPECT_NEAR(hand_m * numbers_of(text, "scale")[0], 0.18, 0.006) << "the head alone";
  }
}

TEST(FirstScene, OfALabelMapHasASurfaceForEachLabel) {
  const Volume map = scalar_grid(49, 0.002, {-0.048, -0.048, -0.048}, [](const Vec3& x) {
    return norm(x) > 0.03 ? 0.0 : norm(x - Vec3{0.01, 0, 0}) < 0.008 ? 250.0 : x.y > 0.0 ? 17.0 : 3.0;
  });
  const std::string text = scene_of(map);
  const Scene scene = parsed(text, map);
  for (const auto& [name, middle_m, other_m] : {std::tuple{"label_250", Vec3{0.01, 0, 0}, Vec3{-0.015, 0.01, 0}},
                                                std::tuple{"label_17", Vec3{-0.01, 0.012, 0}, Vec3{-0.01, -0.012, 0}},
                                                std::tuple{"label_3", Vec3{-0.01, -0.012, 0}, Vec3{0, 0, 0.04}}}) {
    const Field& field = *scene.field({"file." + std::string(name)}).field;
    EXPECT_GT(field.scalar(middle_m).value, 0.9) << name;
    EXPECT_LT(field.scalar(other_m).value, 0.1) << name;
    EXPECT_THAT(text, HasSubstr("[[mode.level]]\nname = \"" + std::string(name) + "\"\nvalue = 0.5"));
  }
  EXPECT_NEAR(hand_m * numbers_of(text, "scale")[0], 0.06, 2.0 * 0.096 / detail::Lattice::longest + 0.002);
}

TEST(Labels, OfAVolumeAreCheckedInOneLine) {
  const auto error = [](const std::string& labels) {
    return error_of("palpa = 1\n[volume.v]\nanalytic = 'sphere'\nsampled = 8\nlabels = " + labels +
                    "\n[[mode]]\nname = 'm'\ntype = 'viscosity'\ndrag_ns_per_m = 1\n");
  };
  EXPECT_EQ(error("{a = 1}"), "no error");
  EXPECT_THAT(error("{a = 'liver'}"), HasSubstr("must be a whole number of the map"));
  EXPECT_THAT(error("{'a b' = 1}"), HasSubstr("is no plain word"));
  EXPECT_THAT(error("{depth = 1}"), HasSubstr("already; give the label another name"));
}

// ---- Flows

/// White noise of standard deviation 1, reproducible by seed.
std::function<Vec3()> noise(unsigned seed) {
  return [random = std::mt19937(seed), normal = std::normal_distribution<double>()]() mutable {
    const double x = normal(random), y = normal(random), z = normal(random);
    return Vec3{x, y, z};
  };
}

TEST(FirstScene, FeelsVorticesWhereThereAreSome) {
  for (const Volume& vortex : {lamb_oseen_vortex(), burgers_vortex()}) {
    const Field& formula = *vortex.fields[0].field;
    const Box box = formula.bounds_m();
    const double fast = formula.value_ranges()[0].max, spacing_m = largest_component(box.size_m()) / 60.0;
    auto random = noise(1);
    const Volume noisy = vector_grid(
        60, spacing_m, [&](const Vec3& x) { return formula.vector(box.centre_m() + x).value + 0.03 * fast * random(); });
    const std::string text = scene_of(noisy);
    EXPECT_THAT(text, HasSubstr("type = \"vortex_line\""));
    EXPECT_THAT(text, HasSubstr("of = \"q(file.velocity)\""));
    EXPECT_THAT(text, Not(HasSubstr("coherence"))) << "3 % of noise need no mask";
  }
}

TEST(FirstScene, HasNoRailInAUniformStreamAndOneWhereItShearsAndTellsUpstreamFromDownstream) {
  const auto text_of = [](double shear_per_s) {
    return scene_of(vector_grid(24, 0.002, [&](const Vec3& x) {
      return Vec3{20.0 + 10.0 * std::tanh(0.1 * shear_per_s * x.y), 0, 0};
    }));
  };
  EXPECT_THAT(text_of(0.0), testing::AllOf(Not(HasSubstr("type = \"follow\"")), HasSubstr("type = \"vector_force\"")));
  EXPECT_THAT(text_of(5000.0), testing::AllOf(HasSubstr("type = \"follow\""), HasSubstr("type = \"vector_force\"")));
}

/// A stream about a ball, or through a tube, with a field that marks the fluid.
Volume with_wall(bool tube, double fluid, double solid) {
  const auto flows = [=](const Vec3& x) { return tube ? std::hypot(x.y, x.z) < 0.012 : norm(x) > 0.02; };
  Volume volume = vector_grid(48, 0.0025, [&](const Vec3& x) {
    return flows(x) ? Vec3{2.0 - (tube ? (x.y * x.y + x.z * x.z) / 0.8e-4 : 0.0), 0, 0} : Vec3{};
  });
  const double first_m = -0.5 * 0.0025 * 47;
  volume.fields.push_back(
      {"inside", "",
       scalar_grid(48, 0.0025, {first_m, first_m, first_m}, [&](const Vec3& x) { return flows(x) ? fluid : solid; })
           .fields[0]
           .field});
  return volume;
}

TEST(FirstScene, HasAWallWhereAFieldSaysWhatIsFluid) {
  for (const bool tube : {false, true}) {
    for (const auto& [fluid, solid] : {std::pair{1.0, 0.0}, {0.0, 1.0}, {255.0, 0.0}}) {
      const Volume volume = with_wall(tube, fluid, solid);
      const std::string text = scene_of(volume);
      SCOPED_TRACE(text);
      const Scene scene = parsed(text, volume);
      const auto wall = std::ranges::find(scene.modes(), "wall", &SceneMode::name);
      ASSERT_NE(wall, scene.modes().end());
      const SurfaceAndFriction& surface = *wall->mode.as<SurfaceAndFriction>();
      ASSERT_EQ(surface.levels.size(), 1U);
      EXPECT_NEAR(surface.levels[0].value, 0.5 * (fluid + solid), 0.01 * std::abs(fluid - solid));
      // A hand comes from the stream upon a body, which holds, and from outside upon a tube, which admits it.
      EXPECT_EQ(surface.solid == SurfaceAndFriction::Solid::high, tube ? fluid > solid : solid > fluid);
      EXPECT_EQ(surface.levels[0].strength_n.constant_n > scene.coupling().max_force_n, !tube);
    }
  }
}

TEST(FirstScene, HoldsBoneAndCutsThroughTissue) {
  const Volume ct = sampled_head();
  const Scene head = parsed(scene_of(ct), ct);
  const auto& levels = head.modes().front().mode.as<SurfaceAndFriction>()->levels;
  ASSERT_EQ(levels.size(), 2U);
  EXPECT_LT(levels[0].strength_n.constant_n, 1.0);
  EXPECT_GT(levels[1].strength_n.constant_n, head.coupling().max_force_n);
  EXPECT_THAT(scene_of(ct), testing::AllOf(HasSubstr("# impact_ns_per_m = 5"), HasSubstr("2.67 mm of hand")));

  for (const bool bright : {true, false}) {
    Volume mr = scalar_grid(49, 0.004, {-0.096, -0.096, -0.096}, [&](const Vec3& x) {
      const double inner = norm(x) < 0.035 ? 200.0 : norm(x) < 0.08 ? 100.0 : 10.0;
      return (bright ? inner : 250.0 - inner) + 3.0 * std::sin(900.0 * x.x) * std::cos(700.0 * x.y);
    });
    mr.format = "nifti", mr.medical_frame = true;
    const std::string text = scene_of(mr);
    SCOPED_TRACE(text);
    const Scene scene = parsed(text, mr);
    const SurfaceAndFriction& tissue = *scene.modes().front().mode.as<SurfaceAndFriction>();
    EXPECT_TRUE(tissue.levels.empty());
    const auto newtons = [&](double value) { return tissue.strength_n.curve.at(bright ? value : 250.0 - value); };
    EXPECT_EQ(newtons(10.0), 0.0);
    EXPECT_GT(newtons(100.0), 0.1);
    EXPECT_GT(newtons(200.0), newtons(100.0));
  }
}

TEST(FirstScene, NamesAFileRelativeToTheSceneWhereBothCanMove) {
  const Volume head = sampled_head();
  const auto file_of = [&](const char* file, const char* folder) {
    VolumeRequest request;
    request.files = {file};
    const std::string text = first_scene(head, request, {.folder = folder});
    const std::size_t begin = text.find("file = ") + 7;
    return text.substr(begin, text.find('\n', begin) - begin);
  };
  EXPECT_EQ(file_of("/data/a/head.nrrd", "/data/a"), "\"head.nrrd\"");
  EXPECT_EQ(file_of("/data/a/head.nrrd", "/data"), "\"a/head.nrrd\"");
  EXPECT_EQ(file_of("/data/a/x.h5:/flow/q", "/data/a/"), "\"x.h5:/flow/q\"");
  EXPECT_EQ(file_of("/data/a/head.nrrd", "/data/b"), "\"/data/a/head.nrrd\"");
  EXPECT_EQ(file_of("/data/a/head.nrrd", ""), "\"/data/a/head.nrrd\"");
  EXPECT_EQ(file_of("in/head.nrrd", "."), "\"in/head.nrrd\"");
  EXPECT_EQ(file_of("in/head.nrrd", "out"), "\"../in/head.nrrd\"");
}

TEST(FirstScene, AsksAboutASizeThatNoPartOfABodyHas) {
  const auto asks = [](double spacing_m, const char* file, const char* field, bool assumed) {
    Volume volume = scalar_grid(8, spacing_m, {}, [](const Vec3& x) { return x.x > x.y ? 1.0 : 0.0; });
    volume.fields[0].name = field;
    volume.length_unit = "m", volume.length_unit_assumed = assumed;
    VolumeRequest request;
    request.files = {file};
    return first_scene(volume, request).find("that long") != std::string::npos;
  };
  for (const char* file : {"/d/blood_vessels.vtu", "/d/Aorta.vti", "/d/head.vti", "/d/carotid.vtk"})
    EXPECT_TRUE(asks(5.0, file, "v", true)) << file;
  for (const char* field : {"shearstress", "ShearStress", "shear_stress", "WSS"})
    EXPECT_TRUE(asks(5.0, "/d/a.vti", field, true)) << field;
  for (const char* file : {"/d/header.vti", "/d/storm.vti", "/d/spearhead7.vti", "/d/lungo.vti"})
    EXPECT_FALSE(asks(5.0, file, "v", true)) << file;
  EXPECT_FALSE(asks(0.02, "/d/aorta.vti", "v", true));
  EXPECT_FALSE(asks(5.0, "/d/aorta.vti", "v", false));
}

TEST(FirstScene, FeelsNoVorticesInAStreamOrInAShear) {
  auto random = noise(2);
  EXPECT_THAT(scene_of(vector_grid(50, 0.002,
                                   [&](const Vec3&) {
                                     return Vec3{1, 0, 0} + 0.03 * random();
                                   })),
              Not(HasSubstr("vortex_")));
  EXPECT_THAT(scene_of(vector_grid(50, 0.002,
                                   [&](const Vec3& x) {
                                     return Vec3{1.0 + 10.0 * x.y, 0, 0} + 0.03 * random();
                                   })),
              Not(HasSubstr("vortex_")));
}

/// The scene of a jet in air with noise as fast as the jet, with or without its magnitude image.
Volume jet_in_air(bool with_signal) {
  auto random = noise(3);
  const auto in_jet = [](const Vec3& x) { return x.y * x.y + x.z * x.z < 0.012 * 0.012; };
  Volume volume = vector_grid(64, 0.001, [&](const Vec3& x) {
    return in_jet(x) ? Vec3{1, 0, 0} + 0.02 * random() : 0.6 * random();
  });
  if (!with_signal) return volume;
  const double first_m = -0.5 * 0.001 * 63;
  volume.fields.push_back({"signal", "",
                           scalar_grid(64, 0.001, {first_m, first_m, first_m},
                                       [&](const Vec3& x) { return (in_jet(x) ? 300.0 : 20.0) + 5.0 * std::abs(random().x); })
                               .fields[0]
                               .field});
  return volume;
}

TEST(FirstScene, TakesNoImageForAWall) { EXPECT_THAT(scene_of(jet_in_air(true)), Not(HasSubstr("name = \"wall\""))); }

TEST(FirstScene, SilencesAirThatIsNoise) {
  for (const bool with_signal : {false, true}) {
    const Volume volume = jet_in_air(with_signal);
    const std::string text = scene_of(volume);
    SCOPED_TRACE(text);
    EXPECT_THAT(text, HasSubstr(with_signal ? "of = \"file.signal\"" : "of = \"coherence(file.velocity)\""));
    const Scene scene = parsed(text, volume);
    // At 95 of 100 points in air each mode is silent; at as many in the jet it makes a force.
    for (const SceneMode& mode : scene.modes()) {
      if (mode.name == "vortex") continue;
      int air = 0, silent = 0, jet = 0, felt = 0;
      for (int n = 1; n <= 4000; ++n) {
        const Vec3 x = detail::halton(n, {{-0.028, -0.028, -0.028}, {0.028, 0.028, 0.028}});
        const double from_axis_m = std::hypot(x.y, x.z);
        double factor = 1.0;
        for (const Mask& mask : mode.masks) factor *= mask.curve.at(scene.field(mask.of).field->scalar(x).value);
        if (from_axis_m > 0.016) ++air, silent += factor < 0.05;
        if (from_axis_m < 0.008) ++jet, felt += factor > 0.5;
      }
      EXPECT_GE(silent, 0.95 * air) << mode.name;
      EXPECT_GE(felt, 0.95 * jet) << mode.name;
    }
  }
}

}  // namespace first_scene_test
}  // namespace palpa::test
