// Vectors that a file has as three arrays: u, v, w.
#include "files.h"
#include "hdf5_file.h"
#include "palpa/data/volume.h"
#include "palpa/file/components.h"
#include "palpa/scene/first_scene.h"
#include "palpa/scene/load_scene.h"

namespace palpa::test {
namespace joined_test {

class Joined : public ReaderTest {
 protected:
  /// Three arrays of numbers on a grid of 3 x 2 x 2, each linear in the position, and one vector array of these numbers.
  fs::path file(const std::array<std::string, 3>& names, const std::string& type = "Float32",
                const std::string& others = {}) const {
    std::string arrays[3], all;
    for (int n = 0; n < 12; ++n) {
      for (int c = 0; c < 3; ++c) {
        const std::string number = std::to_string(10 + c * 20 + (c + 1) * (n % 3) - 2 * (n / 3 % 2) + 5 * (n / 6)) + " ";
        arrays[c] += number, all += number;
      }
    }
    std::string text =
        "<?xml version=\"1.0\"?><VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\"><ImageData "
        "WholeExtent=\"0 2 0 1 0 1\" Origin=\"1 2 3\" Spacing=\"1 2 4\"><Piece Extent=\"0 2 0 1 0 1\"><PointData>";
    for (std::size_t c = 0; c < 3; ++c)
      text += "<DataArray type=\"" + type + "\" Name=\"" + names[c] + "\" format=\"ascii\">" + arrays[c] + "</DataArray>";
    text +=
        "<DataArray type=\"Float32\" Name=\"whole\" NumberOfComponents=\"3\" format=\"ascii\">" + all + "</DataArray>" + others;
    return folder_.write("a.vti", text + "</PointData></Piece></ImageData></VTKFile>");
  }
  static VolumeRequest request_for(const std::vector<std::string>& arrays) {
    VolumeRequest request;
    request.fields = {{"velocity", "", "m/s", arrays}, {"whole", "", ""}};
    return request;
  }
};

TEST_F(Joined, IsTheVectorThatTheFileCouldHaveHad) {
  for (const char* type : {"Float32", "Float64", "Int16", "UInt8", "Int32"}) {
    const Volume volume = read(file({"u", "v", "w"}, type), request_for({"u", "v", "w"}));
    ASSERT_EQ(volume.fields.size(), 2U);
    EXPECT_EQ(volume.fields[0].name, "velocity");
    EXPECT_EQ(volume.fields[0].unit, "m/s");
    ASSERT_EQ(volume.fields[0].field->components(), 3);
    for (const Vec3& at : {Vec3{1, 2, 3}, {1.3, 2.9, 5.5}, {2.9, 4, 7}, {0, 0, 0}}) {
      const VectorSample joined = volume.fields[0].field->vector(at), whole = volume.fields[1].field->vector(at);
      EXPECT_EQ(joined.inside, whole.inside);
      EXPECT_LT(distance(joined.value, whole.value), 1e-5) << type;
    }
  }
}

TEST_F(Joined, ArraysMayComeInAnyOrderAndTwice) {
  const fs::path path = file({"u", "v", "w"});
  const Volume turned = read(path, request_for({"w", "u", "w"})), straight = read(path, request_for({"u", "v", "w"}));
  const Vec3 at{1.5, 3, 5}, t = turned.fields[0].field->vector(at).value, s = straight.fields[0].field->vector(at).value;
  EXPECT_LT(distance(t, {s.z, s.x, s.z}), 1e-6);
}

TEST_F(Joined, WhatCannotBeOneIsRefused) {
  const fs::path path = file({"u", "v", "w"});
  EXPECT_NE(error_of([&] { read(path, request_for({"u", "v", "none"})); }).find("no array 'none'"), std::string::npos);
  EXPECT_NE(error_of([&] { read(path, request_for({"u", "v", "whole"})); }).find("vectors already"), std::string::npos);
  VolumeRequest along_grid = request_for({"u", "v", "w"});
  along_grid.components_along = "index";
  EXPECT_NE(error_of([&] { read(path, along_grid); }).find("components_along"), std::string::npos);
}

TEST_F(Joined, NamesThatBelongTogetherAreFound) {
  const auto found = [&](const std::array<std::string, 3>& names) -> std::string {
    const auto vectors = separate_vectors(read(file(names)));
    if (vectors.empty()) return "";
    EXPECT_EQ(vectors[0].arrays, (std::vector<std::string>{names.begin(), names.end()}));
    return vectors[0].name;
  };
  EXPECT_EQ(found({"u", "v", "w"}), "velocity");
  EXPECT_EQ(found({"U", "V", "W"}), "velocity");
  EXPECT_EQ(found({"vx", "vy", "vz"}), "velocity");
  EXPECT_EQ(found({"velocity_x", "velocity_y", "velocity_z"}), "velocity");
  EXPECT_EQ(found({"Wind-X", "Wind-Y", "Wind-Z"}), "Wind");
  EXPECT_EQ(found({"wss:0", "wss:1", "wss:2"}), "wss");
  EXPECT_EQ(found({"velocity_u", "velocity_v", "velocity_w"}), "velocity");
  EXPECT_EQ(found({"coord_x", "coord_y", "coord_z"}), "") << "positions are no vectors to feel";
  EXPECT_EQ(found({"u", "v", "p"}), "");
  EXPECT_EQ(found({"a_x", "b_y", "c_z"}), "");
  EXPECT_EQ(found({"max", "may", "maz"}), "") << "letters of words";
}

TEST_F(Joined, AFirstSceneFeelsTheVector) {
  const fs::path path = file({"u", "v", "w"});
  VolumeRequest request;
  request.files = {path};
  request.fields = {{"u", "", ""}, {"v", "", ""}, {"w", "", ""}};
  EXPECT_FALSE(with_vectors_joined(request, read(path))) << "the request says itself what its fields are";
  request.fields.clear();
  const auto joined = with_vectors_joined(request, read(path));
  ASSERT_TRUE(joined);
  EXPECT_EQ(joined->fields[0].arrays.size(), 3U);
  const std::string text = first_scene(read_volume(*joined, options_), *joined);
  EXPECT_NE(text.find("fields = {velocity = {arrays = [\"u\", \"v\", \"w\"]}}"), std::string::npos) << text;
  const LoadedScene loaded = parse_scene(text, "first.toml", folder_.path(), volume_reader(options_), standard_modes());
  EXPECT_EQ(loaded.scene.volumes().front().volume.fields.front().field->components(), 3);
  const std::string from = "arrays = [\"u\", \"v\", \"w\"]";
  for (const auto& [wrong, said] : {std::pair{"arrays = [\"u\", \"v\"]", "a list of 3"},
                                    {"array = \"u\", arrays = [\"u\", \"v\", \"w\"]", "one of them"},
                                    {"arrays = \"u\"", "list of texts"}}) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), wrong);
    const std::string error =
        error_of([&] { parse_scene(changed, "first.toml", folder_.path(), volume_reader(options_), standard_modes()); });
    EXPECT_NE(error.find(said), std::string::npos) << error;
  }
}

// The commonest form of simulated 4D-flow MR: /u, /v, /w of one moment.
TEST_F(Joined, ThreeArraysOfHdf5AreFeltAsOneVector) {
  const fs::path path = folder_.path() / "a.h5";
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  std::string parts[3], magnitude;
  for (int n = 0; n < 16 * 16 * 24; ++n) {
    const float y = static_cast<float>(n / 24 % 16) - 7.5F, z = static_cast<float>(n / 24 / 16) - 7.5F;
    const float inside = y * y + z * z < 36.0F ? 1.0F : 0.0F;
    parts[0] += bytes_of(inside * (36.0F - y * y - z * z)), parts[1] += bytes_of(inside * 3.0F * z);
    parts[2] += bytes_of(inside * -3.0F * y), magnitude += bytes_of(100.0F * inside);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    write_array<float>(
        file, std::string("/") + "uvw" [c], { 1, 16, 16, 24 }, parts[c]);
    write_array<float>(
        file, std::string("/mag_") + "uvw" [c], { 1, 16, 16, 24 }, magnitude);
  }
  H5Fclose(file);
  VolumeRequest request;
  request.files = {path};
  request.layout.spacing_m = {0.002, 0.002, 0.002};
  const Volume volume = read_volume(request, options_);
  const auto joined = with_vectors_joined(request, volume);
  ASSERT_TRUE(joined);
  EXPECT_EQ(separate_vectors(volume).size(), 1U);  // the magnitudes of three images are no vector
  const std::string text = first_scene(read_volume(*joined, options_), *joined);
  EXPECT_NE(text.find("velocity = {arrays = [\"u\", \"v\", \"w\"]}"), std::string::npos) << text;
  const LoadedScene loaded = parse_scene(text, "first.toml", folder_.path(), volume_reader(options_), standard_modes());
  EXPECT_GT(loaded.scene.modes().size(), 0U) << text;
}

TEST_F(Joined, ThreeMomentsOfAComponentAreNoVector) {
  for (const char* names : {"uvw", "UVW"}) {
    const fs::path path = folder_.path() / "t.h5";
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    for (int c = 0; c < 3; ++c) write_array<float>(file, std::string("/") + names[c], {3, 4, 5, 6}, std::string(1440, '\0'));
    H5Fclose(file);
    VolumeRequest request;
    request.files = {path};
    request.layout.spacing_m = {1, 1, 1};
    EXPECT_NE(error_of([&] { read_volume(request, options_); }).find("say axes = \"tzyx\""), std::string::npos);
    request.layout.axes = "tzyx";
    const Volume volume = read_volume(request, options_);
    EXPECT_EQ(volume.frames, 3);
    EXPECT_EQ(separate_vectors(volume).size(), 1U);
  }
}

}  // namespace joined_test
}  // namespace palpa::test
