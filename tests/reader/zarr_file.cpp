#include "zarr_file.h"

#include <blosc.h>
#include <zlib.h>
#include <zstd.h>

#include <cmath>
#include <fstream>

namespace palpa::test {
namespace {

using Index = std::vector<std::int64_t>;

std::string list_of(const Index& numbers) {
  std::string text = "[";
  for (std::size_t n = 0; n < numbers.size(); ++n) text += (n == 0 ? "" : ",") + std::to_string(numbers[n]);
  return text + "]";
}

/// CRC-32C bit by bit.
std::uint32_t crc32c(const std::string& bytes) {
  std::uint32_t rest = ~0U;
  for (const char c : bytes) {
    rest ^= static_cast<std::uint8_t>(c);
    for (int bit = 0; bit < 8; ++bit) rest = (rest >> 1) ^ ((rest & 1) != 0 ? 0x82f63b78U : 0U);
  }
  return ~rest;
}

std::string zlib_packed(const std::string& bytes) {
  uLongf size = compressBound(bytes.size());
  std::string packed(size, '\0');
  compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), 1);
  packed.resize(size);
  return packed;
}

std::string encoded(const ZarrToWrite& array, const std::string& bytes) {
  std::string packed = bytes;
  if (array.codec == "gzip") packed = gzipped(bytes);
  if (array.codec == "zlib") packed = zlib_packed(bytes);
  if (array.codec == "zstd") {
    packed.resize(ZSTD_compressBound(bytes.size()));
    packed.resize(ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 1));
  }
  if (array.codec == "blosc") {
    packed.resize(bytes.size() + BLOSC_MAX_OVERHEAD);
    const int size =
        blosc_compress_ctx(5, BLOSC_BITSHUFFLE, 2, bytes.size(), bytes.data(), packed.data(), packed.size(), "lz4", 0, 1);
    packed.resize(static_cast<std::size_t>(size));
  }
  if (array.has_checksum) packed += bytes_of(crc32c(packed));
  return packed;
}

std::string number_bytes(const std::string& type, double value) {
  if (type == "uint8") return bytes_of(static_cast<std::uint8_t>(value));
  if (type == "int16") return bytes_of(static_cast<std::int16_t>(value));
  if (type == "uint16") return bytes_of(static_cast<std::uint16_t>(value));
  if (type == "float32") return bytes_of(static_cast<float>(value));
  return bytes_of(value);
}

/// Calls `use` with each index below `end`, the last index fastest.
void for_each(const Index& end, const std::function<void(const Index&)>& use) {
  Index at(end.size(), 0);
  while (true) {
    use(at);
    std::size_t n = end.size();
    while (n > 0 && ++at[n - 1] == end[n - 1]) at[--n] = 0;
    if (n == 0) return;
  }
}

std::string chunk_bytes(const ZarrToWrite& array, const Index& chunk) {
  std::string bytes;
  for_each(array.chunk, [&](const Index& in_chunk) {
    Index at = in_chunk;
    bool is_inside = true;
    for (std::size_t n = 0; n < at.size(); ++n) {
      at[n] += chunk[n] * array.chunk[n];
      is_inside = is_inside && at[n] < array.shape[n];
    }
    bytes += number_bytes(array.type, is_inside ? array.value(at) : 0.0);
  });
  return encoded(array, bytes);
}

std::string codec_list(const ZarrToWrite& array) {
  std::string list = R"([{"name":"bytes","configuration":{"endian":"little"}})";
  if (array.codec == "blosc") {
    list += R"(,{"name":"blosc","configuration":{"cname":"lz4","clevel":5,"shuffle":"bitshuffle","typesize":2,"blocksize":0}})";
  } else if (array.codec != "raw") {
    list += R"(,{"name":")" + array.codec + R"(","configuration":{"level":1}})";
  }
  if (array.has_checksum) list += R"(,{"name":"crc32c"})";
  return list + "]";
}

std::string metadata(const ZarrToWrite& array) {
  if (array.format == 2) {
    const std::string letters = array.type == "uint8"     ? "|u1"
                                : array.type == "int16"   ? "<i2"
                                : array.type == "uint16"  ? "<u2"
                                : array.type == "float32" ? "<f4"
                                                          : "<f8";
    const std::string compressor = array.codec == "raw"     ? "null"
                                   : array.codec == "blosc" ? R"({"id":"blosc","cname":"lz4","clevel":5,"shuffle":2})"
                                                            : R"({"id":")" + array.codec + R"(","level":1})";
    return R"({"zarr_format":2,"shape":)" + list_of(array.shape) + R"(,"chunks":)" + list_of(array.chunk) + R"(,"dtype":")" +
           letters + R"(","compressor":)" + compressor + R"(,"fill_value":)" + array.fill +
           R"(,"order":"C","filters":null,"dimension_separator":"/"})";
  }
  std::string codecs = codec_list(array);
  if (!array.shard.empty()) {
    codecs = R"([{"name":"sharding_indexed","configuration":{"chunk_shape":)" + list_of(array.chunk) + R"(,"codecs":)" +
             codecs +
             R"(,"index_codecs":[{"name":"bytes","configuration":{"endian":"little"}},{"name":"crc32c"}],"index_location":")" +
             (array.index_at_end ? "end" : "start") + "\"}}]";
  }
  return R"({"zarr_format":3,"node_type":"array","shape":)" + list_of(array.shape) + R"(,"data_type":")" + array.type +
         R"(","chunk_grid":{"name":"regular","configuration":{"chunk_shape":)" +
         list_of(array.shard.empty() ? array.chunk : array.shard) +
         R"(}},"chunk_key_encoding":{"name":"default","configuration":{"separator":"/"}},"fill_value":)" + array.fill +
         R"(,"codecs":)" + codecs + R"(,"attributes":{}})";
}

std::string shard_bytes(const ZarrToWrite& array, const Index& shard, const Index& in_shard, const Index& chunks) {
  std::string data, index;
  std::int64_t entries = 1;
  for (const std::int64_t n : in_shard) entries *= n;
  const std::uint64_t before = array.index_at_end ? 0 : static_cast<std::uint64_t>(16 * entries + 4);
  bool is_empty = true;
  for_each(in_shard, [&](const Index& inner) {
    Index chunk = inner;
    bool is_there = true;
    for (std::size_t n = 0; n < chunk.size(); ++n) {
      chunk[n] += shard[n] * in_shard[n];
      is_there = is_there && chunk[n] < chunks[n];
    }
    is_there = is_there && array.has_chunk(chunk);
    is_empty = is_empty && !is_there;
    const std::string bytes = is_there ? chunk_bytes(array, chunk) : "";
    index +=
        bytes_of(is_there ? before + data.size() : UINT64_MAX) + bytes_of(is_there ? std::uint64_t{bytes.size()} : UINT64_MAX);
    data += bytes;
  });
  if (is_empty) return {};
  index += bytes_of(crc32c(index));
  return array.index_at_end ? data + index : index + data;
}

}  // namespace

void write_text_file(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

void write_zarr_array(const fs::path& folder, const ZarrToWrite& array) {
  write_text_file(folder / (array.format == 2 ? ".zarray" : "zarr.json"), metadata(array));
  const Index unit = array.shard.empty() ? array.chunk : array.shard;
  Index chunks(unit.size()), files(unit.size()), in_file(unit.size());
  for (std::size_t n = 0; n < unit.size(); ++n) {
    chunks[n] = (array.shape[n] + array.chunk[n] - 1) / array.chunk[n];
    files[n] = (array.shape[n] + unit[n] - 1) / unit[n];
    in_file[n] = unit[n] / array.chunk[n];
  }
  for_each(files, [&](const Index& at) {
    fs::path file = array.format == 2 ? folder : folder / "c";
    for (const std::int64_t n : at) file /= std::to_string(n);
    const std::string bytes = !array.shard.empty()  ? shard_bytes(array, at, in_file, chunks)
                              : array.has_chunk(at) ? chunk_bytes(array, at)
                                                    : "";
    if (!bytes.empty()) write_text_file(file, bytes);
  });
}

std::string multiscales(int octaves, bool halves, const std::string& version) {
  std::string text =
      R"("multiscales":[{"version":")" + version +
      R"(","axes":[{"name":"z","type":"space","unit":"micrometer"},{"name":"y","type":"space","unit":"micrometer"},)"
      R"({"name":"x","type":"space","unit":"micrometer"}],"datasets":[)";
  for (int n = 0; n < octaves; ++n) {
    const std::string scale = std::to_string(1 << n), move = std::to_string(0.5 * ((1 << n) - 1));
    text += std::string(n == 0 ? "" : ",") + R"({"path":")" + std::to_string(n) +
            R"(","coordinateTransformations":[{"type":"scale","scale":[)" + scale + "," + scale + "," + scale + "]}" +
            (halves ? R"(,{"type":"translation","translation":[)" + move + "," + move + "," + move + "]}" : "") + "]}";
  }
  return text + "]}]";
}

void write_zarr_group(const fs::path& folder, const std::string& attributes, int format) {
  if (format == 3) {
    write_text_file(folder / "zarr.json",
                    R"({"zarr_format":3,"node_type":"group","attributes":{"ome":{"version":"0.5",)" + attributes + "}}}");
    return;
  }
  write_text_file(folder / ".zgroup", R"({"zarr_format":2})");
  write_text_file(folder / ".zattrs", "{" + attributes + "}");
}

void write_zarr_image(const fs::path& folder, std::int64_t side, int format, const std::string& codec,
                      const std::function<double(std::int64_t i, std::int64_t j, std::int64_t k)>& value) {
  write_zarr_group(folder, multiscales(3, true), format);
  for (int n = 0; n < 3; ++n) {
    const std::int64_t step = std::int64_t{1} << n, length = side / step;
    ZarrToWrite array{
        .format = format, .shape = {length, length, length}, .chunk = {16, 16, 16}, .type = "int16", .codec = codec};
    if (format == 3) array.shard = {32, 32, 32};
    array.value = [&](const Index& at) {
      double sum = 0.0;
      for (std::int64_t k = 0; k < step; ++k)
        for (std::int64_t j = 0; j < step; ++j)
          for (std::int64_t i = 0; i < step; ++i) sum += value(at[2] * step + i, at[1] * step + j, at[0] * step + k);
      return std::floor(sum / static_cast<double>(step * step * step) + 0.5);
    };
    write_zarr_array(folder / std::to_string(n), array);
  }
}

}  // namespace palpa::test
