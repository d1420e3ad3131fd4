#include "sets_to_damage.h"

#include <array>

#include "data_sets.h"
#include "dicom_file.h"
#include "hdf5_file.h"
#include "openfoam_case.h"
#include "tiff_writer.h"
#include "zarr_file.h"

namespace palpa::test {
namespace {

const FileGrid grid{{6, 5, 4}, {{{0.5, 0, 0}, {0, 0.25, 0}, {0, 0, 2}}}, {1, 2, 3}};

std::string numbers_of(const FileGrid& of = grid) {
  return linear_voxels<double>(of, [](const Vec3& p) { return p; });
}

SetToDamage dicom(const std::string& name, gdcm::TransferSyntax::TSType syntax, bool whole_folder) {
  return {name, [=](const TemporaryFolder& folder) {
            DicomSeries series;
            series.columns = 40, series.rows = 32;
            for (int n = 0; n < 5; ++n) {
              const fs::path file =
                  folder.write("i" + std::to_string(n), series.file(series.image(series.at_mm({0, 0, double(n)}), n)));
              if (syntax != gdcm::TransferSyntax::ExplicitVRLittleEndian) compress_dicom(file, syntax);
            }
            return whole_folder ? folder.path() : folder.path() / "i0";
          }};
}

SetToDamage hdf5_array() {
  VolumeRequest request;
  request.layout.spacing_m = {0.5, 0.25, 2};
  return {"array.h5",
          [](const TemporaryFolder& folder) {
            const fs::path path = folder.path() / "array.h5";
            const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
            write_array<double>(file, "/flow/p", {4, 5, 6}, numbers_of(), true);
            H5Fclose(file);
            return path;
          },
          {},
          request};
}

/// An array of netCDF-4 with all supported attributes: a dimension scale for each index, packing, fill values.
SetToDamage hdf5_conventions() {
  return {"conventions.nc", [](const TemporaryFolder& folder) {
            const fs::path path = folder.path() / "conventions.nc";
            const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
            std::string numbers;
            for (std::int16_t n = 0; n < 240; ++n) numbers += bytes_of(n);
            write_array<std::int16_t>(file, "/T", {2, 4, 5, 6}, numbers);
            const hid_t array = H5Dopen2(file, "/T", H5P_DEFAULT), type = H5Tvlen_create(H5T_STD_REF_OBJ);
            hobj_ref_t references[4];
            hvl_t lists[4];
            const char* const names[] = {"/time", "/z", "/y", "/x"};
            const char* const units[] = {"s since 2000-01-01", "km", "degrees_north", "degrees_east"};
            for (std::size_t n = 0; n < 4; ++n) {
              std::string at;
              const hsize_t length = std::array<hsize_t, 4>{2, 4, 5, 6}[n];
              for (hsize_t i = 0; i < length; ++i) at += bytes_of(0.5 * static_cast<double>(i * (n == 1 ? i : 1)));
              write_array<double>(file, names[n], {length}, at);
              const hid_t scale = H5Dopen2(file, names[n], H5P_DEFAULT);
              write_text(scale, "units", units[n]);
              H5Dclose(scale);
              H5Rcreate(&references[n], file, names[n], H5R_OBJECT, -1);
              lists[n] = {1, &references[n]};
            }
            const hsize_t rank = 4;
            const hid_t space = H5Screate_simple(1, &rank, nullptr);
            const hid_t list = H5Acreate2(array, "DIMENSION_LIST", type, space, H5P_DEFAULT, H5P_DEFAULT);
            H5Awrite(list, type, lists);
            write_numbers(array, "scale_factor", {0.01}), write_numbers(array, "add_offset", {273.15});
            write_numbers(array, "missing_value", {3, 5, 200}), write_numbers(array, "valid_range", {270, 280});
            write_text(array, "units", "K"), write_text(array, "_Unsigned", "true");
            H5Aclose(list), H5Sclose(space), H5Tclose(type), H5Dclose(array), H5Fclose(file);
            return path;
          }};
}

SetToDamage hdf5_image() {
  return {"image.vtkhdf", [](const TemporaryFolder& folder) {
            const fs::path path = folder.path() / "image.vtkhdf";
            const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
            write_array<double>(file, "/VTKHDF/PointData/p", {4, 5, 6}, numbers_of());
            const hid_t root = H5Gopen2(file, "VTKHDF", H5P_DEFAULT);
            write_text(root, "Type", "ImageData");
            write_numbers(root, "WholeExtent", {0, 5, 0, 4, 0, 3});
            H5Gclose(root), H5Fclose(file);
            return path;
          }};
}

SetToDamage raw() {
  VolumeRequest request;
  request.layout = {.type = "float64", .header_bytes = 8, .dims = {6, 5, 4}, .spacing_m = {0.5, 0.25, 2}};
  return {"numbers.raw",
          [](const TemporaryFolder& folder) { return folder.write("numbers.raw", "12345678" + numbers_of()); },
          {},
          request};
}

/// Slices of the grid, as files "s0" and on.
std::vector<std::string> write_slices(const TemporaryFolder& folder) {
  const std::string numbers = numbers_of();
  const std::size_t slice = numbers.size() / 4;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < 4; ++k) {
    names.push_back("s" + std::to_string(k));
    folder.write(names.back(), numbers.substr(k * slice, slice));
  }
  return names;
}

std::string lines(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += name + "\n";
  return text;
}

const char* const nrrd_header =
    "NRRD0004\ntype: double\ndimension: 3\nspace: LPS\nsizes: 6 5 4\nspace directions: (0.5,0,0) (0,0.25,0) (0,0,2)\n"
    "space origin: (1,2,3)\nendian: little\n";
const char* const meta_header =
    "ObjectType = Image\nNDims = 3\nBinaryData = True\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 1 2 3\n"
    "ElementSpacing = 0.5 0.25 2\nDimSize = 6 5 4\nElementType = MET_DOUBLE\n";

SetToDamage one_file(const std::string& name, const std::string& bytes) {
  return {name, [=](const TemporaryFolder& folder) { return folder.write(name, bytes); }};
}

SetToDamage in_slices(const std::string& name, const std::string& header) {
  return {name,
          [=](const TemporaryFolder& folder) { return folder.write(name, header + lines(write_slices(folder))); },
          {"s0", "s2"}};
}

/// NIfTI's two versions, whose headers differ in their offsets.
std::string nifti_header(int version, bool in_two_files) {
  std::string h(version == 1 ? 352 : 544, '\0');
  const auto put = [&](std::size_t at, auto value) { h.replace(at, sizeof value, bytes_of(value)); };
  const std::int64_t dim[8] = {3, 6, 5, 4, 1, 1, 1, 1};
  const double pixdim[8] = {1, 0.5, 0.25, 2, 1, 1, 1, 1}, rows[12] = {0.5, 0, 0, 1, 0, 0.25, 0, 2, 0, 0, 2, 3};
  const std::string magic = (in_two_files ? "ni" : "n+") + std::to_string(version);
  if (version == 1) {
    put(0, std::int32_t{348}), put(70, std::int16_t{64}), put(72, std::int16_t{64}), h[123] = 2;
    for (std::size_t d = 0; d < 8; ++d) put(40 + 2 * d, static_cast<std::int16_t>(dim[d]));
    for (std::size_t d = 0; d < 8; ++d) put(76 + 4 * d, static_cast<float>(pixdim[d]));
    put(108, in_two_files ? 0.0F : 352.0F), put(254, std::int16_t{1});
    for (std::size_t n = 0; n < 12; ++n) put(280 + 4 * n, static_cast<float>(rows[n]));
    h.replace(344, 3, magic);
  } else {
    put(0, std::int32_t{540}), put(12, std::int16_t{64}), put(14, std::int16_t{64}), put(500, std::int32_t{2});
    h.replace(4, 8, magic + std::string("\0\r\n\x1a\n", 5));
    for (std::size_t d = 0; d < 8; ++d) put(16 + 8 * d, dim[d]), put(104 + 8 * d, pixdim[d]);
    put(168, std::int64_t{544}), put(348, std::int32_t{1});
    for (std::size_t n = 0; n < 12; ++n) put(400 + 8 * n, rows[n]);
  }
  return h;
}

SetToDamage nifti_in_two_files() {
  return {"pair.hdr",
          [](const TemporaryFolder& folder) {
            folder.write("pair.img", numbers_of());
            return folder.write("pair.hdr", nifti_header(1, true));
          },
          {"pair.img"}};
}

/// Two bent blocks of 4 × 3 × 3 points and their solution.
SetToDamage plot3d_blocks() {
  return {"blocks.xyz",
          [](const TemporaryFolder& folder) {
            std::string xyz = bytes_of(std::int32_t{2});
            for (const std::int32_t n : {4, 3, 3, 4, 3, 3}) xyz += bytes_of(n);
            std::string q = xyz;
            for (int block = 0; block < 2; ++block) {
              for (int n = 0; n < 36; ++n) xyz += bytes_of(static_cast<float>(n % 4 + 3 * block + 0.1 * (n / 4)));
              for (int n = 0; n < 36; ++n) xyz += bytes_of(static_cast<float>(n / 4 % 3));
              for (int n = 0; n < 36; ++n) xyz += bytes_of(static_cast<float>(n / 12));
              for (int n = 0; n < 4; ++n) q += bytes_of(0.5F);
              for (int n = 0; n < 5 * 36; ++n) q += bytes_of(static_cast<float>(n < 36 ? 1.0 : 0.01 * n));
            }
            folder.write("blocks.q", q);
            return folder.write("blocks.xyz", xyz);
          },
          {"blocks.q"}};
}

/// In one block, as text.
SetToDamage plot3d_text() {
  return {"text.xyz",
          [](const TemporaryFolder& folder) {
            std::string xyz = "4 3 3\n", q = "4 3 3\n0.5 0 1D6 0\n36*1.5\n";
            for (int c = 0; c < 3; ++c) {
              for (int n = 0; n < 36; ++n)
                xyz += std::to_string(c == 0 ? n % 4 + 0.1 * (n / 4) : c == 1 ? n / 4 % 3 : n / 12) + "\n";
            }
            for (int n = 0; n < 4 * 36; ++n) q += std::to_string(0.01 * n) + (n % 6 == 5 ? "\n" : " ");
            folder.write("text.q", q);
            return folder.write("text.xyz", xyz);
          },
          {"text.q"}};
}

SetToDamage time_series() {
  return {"series",
          [](const TemporaryFolder& folder) {
            for (const char* name : {"phase_1.mha", "phase_2.mha", "phase_10.mha"})
              folder.write(name, std::string(meta_header) + "ElementDataFile = LOCAL\n" + numbers_of());
            return folder.path();
          },
          {},
          {},
          "phase_*.mha"};
}

SetToDamage dicom_frames() {
  return {"dicom_frames", [](const TemporaryFolder& folder) {
            DicomSeries series;
            DicomElements image = series.image(series.origin_mm, 1);
            std::string pixels;
            for (int n = 0; n < 4; ++n) pixels += series.pixels(series.at_mm({0, 0, double(n)}));
            image.set(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.2.1");
            image.set(0x00280008, "IS", "4");
            image.set(0x7fe00010, "OW", pixels);
            return folder.write("frames.dcm", series.file(image));
          }};
}

SetToDamage dicom_deflated() {
  return {"dicom_deflated", [](const TemporaryFolder& folder) {
            const DicomSeries series;
            return folder.write("deflated.dcm", deflated_file(series, series.image(series.origin_mm, 1)));
          }};
}

/// A store of two octaves with facts, in many small files, or in shards whose index is at their end or start.
SetToDamage store(const std::string& name, int format, bool chunks) {
  SetToDamage set{name, [=](const TemporaryFolder& folder) {
                    const fs::path path = folder.path() / (name + ".zarr");
                    write_zarr_group(path, multiscales(2, true), format);
                    for (int n = 0; n < 2; ++n) {
                      const std::int64_t side = 16 >> n;
                      ZarrToWrite array{.format = format, .shape = {side, side, side}, .chunk = {8, 8, 8}, .type = "int16"};
                      array.codec = format == 2 ? "blosc" : n == 0 ? "zstd" : "gzip";
                      if (format == 3) array.shard = {16, 16, 16}, array.index_at_end = n == 0, array.has_checksum = n == 0;
                      array.value = [](const std::vector<std::int64_t>& at) {
                        return static_cast<double>(at[0] + 20 * at[1] + 300 * at[2]);
                      };
                      write_zarr_array(path / std::to_string(n), array);
                    }
                    ZarrToWrite facts{
                        .format = format, .shape = {1, 1, 2, 2, 2, 4}, .chunk = {1, 1, 2, 2, 2, 4}, .type = "float64"};
                    facts.value = [](const std::vector<std::int64_t>& at) { return static_cast<double>(at[5]); };
                    write_zarr_array(path / "palpa/facts/0", facts);
                    return path;
                  }};
  set.chunks = chunks;
  return set;
}

}  // namespace

std::vector<SetToDamage> sets_to_damage(const fs::path& data_folder) {
  std::vector<SetToDamage> sets;
  for (const std::vector<DataSet>& kind : {data_sets(), refused_sets()}) {
    for (const DataSet& set : kind) {
      sets.push_back({set.file, [file = data_folder / set.file](const TemporaryFolder&) { return file; }, set.with});
    }
  }
  using Syntax = gdcm::TransferSyntax;
  for (const bool folder : {false, true}) {
    const std::string what = folder ? "dicom_folder_" : "dicom_";
    sets.push_back(dicom(what + "plain", Syntax::ExplicitVRLittleEndian, folder));
    sets.push_back(dicom(what + "jpeg", Syntax::JPEGLosslessProcess14_1, folder));
    sets.push_back(dicom(what + "jpeg_ls", Syntax::JPEGLSLossless, folder));
    sets.push_back(dicom(what + "jpeg_2000", Syntax::JPEG2000Lossless, folder));
    sets.push_back(dicom(what + "rle", Syntax::RLELossless, folder));
  }
  sets.push_back({"openfoam", [](const TemporaryFolder& folder) {
                    write_openfoam_case(folder);
                    return folder.path();
                  }});
  sets.push_back(hdf5_array());
  sets.push_back(hdf5_conventions());
  sets.push_back(hdf5_image());
  sets.push_back(raw());
  sets.push_back(one_file("plain.nrrd", std::string(nrrd_header) + "encoding: raw\n\n" + numbers_of()));
  sets.push_back(in_slices("list.nhdr", std::string(nrrd_header) + "encoding: raw\ndata file: LIST\n"));
  sets.push_back(one_file("plain.mha", std::string(meta_header) + "ElementDataFile = LOCAL\n" + numbers_of()));
  sets.push_back(in_slices("list.mhd", std::string(meta_header) + "ElementDataFile = LIST\n"));
  sets.push_back(one_file("plain_1.nii", nifti_header(1, false) + numbers_of()));
  sets.push_back(one_file("plain_2.nii", nifti_header(2, false) + numbers_of()));
  sets.push_back(nifti_in_two_files());
  sets.push_back(one_file("packed.nrrd.gz", gzipped(std::string(nrrd_header) + "encoding: raw\n\n" + numbers_of())));
  sets.push_back(plot3d_blocks());
  sets.push_back(plot3d_text());
  sets.push_back(dicom_frames());
  sets.push_back(dicom_deflated());
  sets.push_back(time_series());
  sets.push_back(one_file("strips.tif", TiffToWrite{.bits = 32, .format = 3, .deflated = true, .pixels_per_cm = 100}.bytes()));
  sets.push_back(one_file("tiles.tif", TiffToWrite{.is_bigtiff = true, .big_endian = true, .tile = 16}.bytes()));
  sets.push_back({"tiff_stack", [](const TemporaryFolder& folder) {
                    write_tiff_stack(folder.path() / "stack", {.description = "ImageJ=1\nunit=um\nspacing=2\n"}, folder);
                    return folder.path() / "stack";
                  }});
  for (const int format : {2, 3}) {
    sets.push_back(store("image_v" + std::to_string(format), format, false));
    sets.push_back(store("chunks_v" + std::to_string(format), format, true));
  }
  for (SetToDamage& set : vtk_sets_to_damage()) sets.push_back(std::move(set));
  return sets;
}

}  // namespace palpa::test
