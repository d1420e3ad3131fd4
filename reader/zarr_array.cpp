#include "zarr_array.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "palpa/base/wording.h"
#include "palpa/file/store_protocol.h"
#include "zarr_half.h"

namespace palpa::reader {
namespace {

using protocol::RawType;

constexpr std::uint64_t most_index_bytes = std::uint64_t{16} << 20;  ///< of a shard: a million chunks
constexpr bool machine_is_big = std::endian::native == std::endian::big;

/// Type by its name in version 3. Throws LoadError.
ZarrType type_named(const std::string& name, const ZarrMetadata& of) {
  ZarrType type{.name = name};
  if (name == "float16") {
    type.raw = RawType::uint16, type.half = true, type.delivered = VoxelType::float32;
    return type;
  }
  static constexpr std::string_view refused[] = {"int64", "uint64", "complex64", "complex128"};
  if (std::ranges::find(refused, name) != std::end(refused)) {
    throw of.error("of the type " + name + ", which is not read; convert it to " +
                   (name.starts_with("complex") ? "its magnitude, float32" : "int32 or float64"));
  }
  static constexpr std::string_view known[] = {"int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"};
  if (name != "bool" && std::ranges::find(known, name) == std::end(known)) {
    throw of.error("of the type " + detail::in_quotes(name) +
                   ", which is not read; bool, int8 to int32, uint8 to uint32 and float16 to float64 are");
  }
  type.raw = name == "bool" ? RawType::uint8 : protocol::type_named(name);
  type.delivered = protocol::exact_type(type.raw);
  return type;
}

/// Type by version 2's letters: "<i2". Throws LoadError.
ZarrType type_of_letters(const ZarrJson& letters, const ZarrMetadata& of) {
  const std::string text = letters.is_string() ? letters.get<std::string>() : std::string();
  std::string name;
  if (text.size() >= 3 && std::string_view("<>|").find(text[0]) != std::string_view::npos) {
    int bytes = 0;
    const auto [end, problem] = std::from_chars(text.data() + 2, text.data() + text.size(), bytes);
    const char kind = text[1];
    const bool is_whole = problem == std::errc{} && end == text.data() + text.size() && bytes >= 1 && bytes <= 16;
    const char* stem = kind == 'i' ? "int" : kind == 'u' ? "uint" : kind == 'f' ? "float" : kind == 'c' ? "complex" : "";
    if (is_whole && *stem != '\0') name = stem + std::to_string(8 * bytes);
    if (is_whole && kind == 'b' && bytes == 1) name = "bool";
  }
  if (name.empty()) {
    throw of.error("of the type " + detail::in_quotes(letters.is_string() ? text : "with parts") +
                   ", which is not read; bool, int8 to int32, uint8 to uint32 and float16 to float64 are");
  }
  ZarrType type = type_named(name, of);
  type.swapped = type.bytes() > 1 && (text[0] == '>') != machine_is_big;
  return type;
}

/// Value of an absent chunk. Throws LoadError.
double fill_of(const ZarrJson* fill, const ZarrType& type, const ZarrMetadata& of) {
  if (fill == nullptr) return 0.0;
  const bool is_floating =
      type.delivered == VoxelType::float32 || (type.delivered == VoxelType::float64 && type.raw != RawType::uint32);
  if (fill->is_boolean()) return fill->get<bool>() ? 1.0 : 0.0;
  if (fill->is_string() && is_floating) {
    const auto& word = fill->get_ref<const std::string&>();
    if (word == "NaN") return std::numeric_limits<double>::quiet_NaN();
    if (word == "Infinity") return std::numeric_limits<double>::infinity();
    if (word == "-Infinity") return -std::numeric_limits<double>::infinity();
    std::uint64_t bits = 0;  // "0x7fc00000", the number's bits
    const bool is_hex = word.starts_with("0x") && word.size() == 2 + 2 * type.bytes();
    if (is_hex && std::from_chars(word.data() + 2, word.data() + word.size(), bits, 16).ptr == word.data() + word.size()) {
      if (type.half) return half_number(static_cast<std::uint16_t>(bits));
      return type.bytes() == 4 ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)))
                               : std::bit_cast<double>(bits);
    }
  }
  if (fill->is_number()) {
    const auto number = fill->get<double>();
    bool fits = is_floating;
    if (!is_floating) {
      protocol::with_type(type.raw, [&](auto value) {
        using Number = decltype(value);
        fits = number == std::floor(number) && number >= static_cast<double>(std::numeric_limits<Number>::lowest()) &&
               number <= static_cast<double>(std::numeric_limits<Number>::max());
      });
    }
    if (fits) return type.delivered == VoxelType::float32 ? static_cast<double>(static_cast<float>(number)) : number;
  }
  throw of.error("whose 'fill_value' is no number of the type " + type.name + "; write the store again");
}

/// Words of a compressor with its settings: "blosc (lz4, bitshuffle)". Throws LoadError.
std::string words_of_blosc(const ZarrJson& settings, const ZarrMetadata& of) {
  const std::string name = ZarrMetadata::text(settings, "cname", "lz4");
  static constexpr std::string_view known[] = {"lz4", "lz4hc", "zstd", "zlib", "blosclz"};
  if (std::ranges::find(known, name) == std::end(known)) {
    throw of.error("compressed by blosc's " + detail::in_quotes(name) +
                   ", which is not read; lz4, lz4hc, zstd, zlib and blosclz are");
  }
  const ZarrJson* shuffle = ZarrMetadata::member(settings, "shuffle");
  std::string how = shuffle != nullptr && shuffle->is_string() ? shuffle->get<std::string>() : "";
  if (shuffle != nullptr && shuffle->is_number_integer()) {
    const auto number = shuffle->get<std::int64_t>();
    how = number == 0 ? "noshuffle" : number == 1 ? "shuffle" : number == 2 ? "bitshuffle" : "";
  }
  const bool is_known = how == "shuffle" || how == "bitshuffle";
  return "blosc (" + name + (is_known ? ", " + how : "") + ")";
}

/// Adds the codec of a name, in any version. Throws LoadError.
void add_codec(ZarrArray& to, const std::string& name, const ZarrJson& settings, const ZarrMetadata& of) {
  const auto add = [&](ZarrCodec codec, const std::string& words) {
    to.codecs.insert(to.codecs.begin(), codec);
    if (codec == ZarrCodec::crc32c) return;
    if (to.codec_words != "not compressed") throw of.error("compressed twice, which is not read; compress it once");
    to.codec_words = words;
  };
  if (name == "blosc") return add(ZarrCodec::blosc, words_of_blosc(settings, of));
  if (name == "zlib") return add(ZarrCodec::zlib, "zlib");
  if (name == "gzip") return add(ZarrCodec::gzip, "gzip");
  if (name == "zstd") return add(ZarrCodec::zstd, "zstd");
  if (name == "crc32c") return add(ZarrCodec::crc32c, "");
  throw of.error("with the codec " + detail::in_quotes(name) + ", which is not read; blosc, zstd, gzip and zlib are");
}

void take_axes(ZarrArray& to, const ZarrJson* names) {
  if (names == nullptr || !names->is_array() || names->size() != to.shape.size()) return;
  for (const ZarrJson& name : *names) to.axes.push_back(name.is_string() ? name.get<std::string>().substr(0, 32) : "");
}

ZarrArray version_2(const ZarrMetadata& of, const std::string& path) {
  ZarrArray made{.path = path};
  made.shape = of.whole_numbers(of.root, "shape", 1);
  made.chunk = made.shard = of.whole_numbers(of.root, "chunks", 1);
  const ZarrJson* letters = ZarrMetadata::member(of.root, "dtype");
  made.type = type_of_letters(letters != nullptr ? *letters : ZarrJson(), of);
  made.fill = fill_of(ZarrMetadata::member(of.root, "fill_value"), made.type, of);
  if (const ZarrJson* filters = ZarrMetadata::member(of.root, "filters"); filters != nullptr && !filters->empty())
    throw of.error("with filters, which are not read; write the store without filters");
  if (const ZarrJson* packer = ZarrMetadata::member(of.root, "compressor"))
    add_codec(made, ZarrMetadata::text(*packer, "id"), *packer, of);
  const std::string separator = ZarrMetadata::text(of.root, "dimension_separator", ".");
  if (separator != "." && separator != "/")
    throw of.error("whose 'dimension_separator' is " + detail::in_quotes(separator) + "; it is '.' or '/'");
  made.separator = separator[0];
  const std::string order = ZarrMetadata::text(of.root, "order", "C");
  if (order != "C" && order != "F") throw of.error("whose 'order' is " + detail::in_quotes(order) + "; it is 'C' or 'F'");
  made.stride.assign(made.chunk.size(), 1);
  if (order == "F") made.stride.front() = -1;  // until the chunk's size is checked
  return made;
}

/// Name and settings of a codec of version 3: an object, or a bare name.
std::pair<std::string, ZarrJson> codec_of(const ZarrJson& codec) {
  if (codec.is_string()) return {codec.get<std::string>(), ZarrJson::object()};
  const ZarrJson* settings = ZarrMetadata::member(codec, "configuration");
  return {ZarrMetadata::text(codec, "name"), settings != nullptr ? *settings : ZarrJson::object()};
}

const ZarrJson& list_of(const ZarrJson& of, const char* key, const ZarrMetadata& metadata) {
  const ZarrJson* list = ZarrMetadata::member(of, key);
  if (list == nullptr || !list->is_array() || list->empty() || list->size() > 8)
    throw metadata.error("whose '" + std::string(key) + "' is no list of up to 8 codecs; write the store again");
  return *list;
}

void check_transpose(const ZarrJson& settings, const ZarrMetadata& of) {
  const ZarrJson* order = ZarrMetadata::member(settings, "order");
  bool is_plain = order != nullptr && (order->is_array() || *order == "C");
  for (std::size_t n = 0; is_plain && order->is_array() && n < order->size(); ++n) is_plain = (*order)[n] == n;
  if (!is_plain) throw of.error("with the codec 'transpose', which is not read; write the array in C order");
}

/// Codecs of chunks: bytes, then compressors and checksums. Throws LoadError.
void take_codecs(ZarrArray& to, const ZarrJson& list, const ZarrMetadata& of) {
  bool has_bytes = false;
  for (const ZarrJson& codec : list) {
    const auto [name, settings] = codec_of(codec);
    if (name == "transpose" && !has_bytes) {
      check_transpose(settings, of);
    } else if (name == "bytes" && !has_bytes) {
      const std::string endian = ZarrMetadata::text(settings, "endian", "little");
      if (endian != "little" && endian != "big") throw of.error("with bytes neither little- nor big-endian; write it anew");
      to.type.swapped = to.type.bytes() > 1 && (endian == "big") != machine_is_big;
      has_bytes = true;
    } else if (name == "sharding_indexed") {
      throw of.error("with shards within shards, or compressed as a whole, which are not read; write plain shards");
    } else if (!has_bytes) {
      throw of.error("whose codecs do not begin with 'bytes' but " + detail::in_quotes(name) +
                     ", which is not read; it is needed");
    } else {
      add_codec(to, name, settings, of);
    }
  }
  if (!has_bytes) throw of.error("without the codec 'bytes'; write the store again");
}

void take_shards(ZarrArray& to, const ZarrJson& settings, const ZarrMetadata& of) {
  to.has_shards = true;
  to.chunk = of.whole_numbers(settings, "chunk_shape", 1);
  const std::string at = ZarrMetadata::text(settings, "index_location", "end");
  if (at != "end" && at != "start") throw of.error("whose shards have their index neither at the end nor at the start");
  to.index_at_end = at == "end";
  take_codecs(to, list_of(settings, "codecs", of), of);
  if (ZarrMetadata::member(settings, "index_codecs") == nullptr) return;
  ZarrArray index{.type = {.name = "uint64", .raw = RawType::uint64}};
  take_codecs(index, list_of(settings, "index_codecs", of), of);
  const bool is_plain = index.codecs.empty() || index.codecs == std::vector{ZarrCodec::crc32c};
  if (!is_plain || index.type.swapped)
    throw of.error("whose shards have an index that is compressed or big-endian, which is not read; write plain shards");
  to.index_has_checksum = !index.codecs.empty();
}

ZarrArray version_3(const ZarrMetadata& of, const std::string& path) {
  if (ZarrMetadata::text(of.root, "node_type") != "array")
    throw of.error("that is of a group, not of an array; name an array, or write the store again");
  ZarrArray made{.path = path, .format = 3};
  made.shape = of.whole_numbers(of.root, "shape", 1);
  const ZarrJson* grid = ZarrMetadata::member(of.root, "chunk_grid");
  if (grid == nullptr || ZarrMetadata::text(*grid, "name") != "regular")
    throw of.error("whose chunks form no regular grid, which is not read; write chunks of one shape");
  const ZarrJson* shape = ZarrMetadata::member(*grid, "configuration");
  made.chunk = made.shard = of.whole_numbers(shape != nullptr ? *shape : ZarrJson(), "chunk_shape", 1);
  made.type = type_named(ZarrMetadata::text(of.root, "data_type", "of no plain name"), of);
  made.fill = fill_of(ZarrMetadata::member(of.root, "fill_value"), made.type, of);
  if (const ZarrJson* more = ZarrMetadata::member(of.root, "storage_transformers"); more != nullptr && !more->empty())
    throw of.error("with storage transformers, which are not read; write the store without them");
  const ZarrJson keys_or_none = of.root.value("chunk_key_encoding", ZarrJson::object());
  const auto [encoding, settings] = codec_of(keys_or_none);
  const bool is_old = encoding == "v2";
  if (!is_old && encoding != "default")
    throw of.error("whose 'chunk_key_encoding' is neither 'default' nor 'v2'; write the store again");
  const std::string separator = ZarrMetadata::text(settings, "separator", is_old ? "." : "/");
  if (separator != "." && separator != "/") throw of.error("whose 'separator' is neither '.' nor '/'; write the store again");
  made.separator = separator[0];
  if (!is_old) made.prefix = "c" + separator;
  const ZarrJson& codecs = list_of(of.root, "codecs", of);
  if (const auto [name, configuration] = codec_of(codecs.front()); name == "sharding_indexed" && codecs.size() == 1) {
    take_shards(made, configuration, of);
  } else {
    take_codecs(made, codecs, of);
  }
  take_axes(made, ZarrMetadata::member(of.root, "dimension_names"));
  made.stride.assign(made.chunk.size(), 1);
  return made;
}

/// Checks sizes, and sets the strides. Throws LoadError.
void check_sizes(ZarrArray& array, const ZarrMetadata& of, std::uint64_t most_chunk_bytes) {
  const std::size_t rank = array.shape.size();
  if (array.chunk.size() != rank || array.shard.size() != rank)
    throw of.error("whose shape and chunks have different numbers of indices; write the store again");
  std::uint64_t bytes = array.type.bytes(), index_bytes = 16;
  for (std::size_t n = 0; n < rank; ++n) {
    const bool is_too_large = __builtin_mul_overflow(bytes, static_cast<std::uint64_t>(array.chunk[n]), &bytes);
    if (is_too_large || bytes > most_chunk_bytes) {
      throw of.error("with chunks of more than " + protocol::readable_bytes(static_cast<double>(most_chunk_bytes)) +
                     "; write smaller ones (32 × 32 × 32), or convert it by palpa convert");
    }
    if (array.shard[n] % array.chunk[n] != 0) throw of.error("whose shards are no whole number of chunks; write it anew");
    const auto chunks = static_cast<std::uint64_t>(array.shard[n] / array.chunk[n]);
    if (__builtin_mul_overflow(index_bytes, chunks, &index_bytes) || index_bytes > most_index_bytes)
      throw of.error("with shards of more than a million chunks; write smaller shards");
  }
  const bool is_fortran = array.stride.front() < 0;
  std::int64_t step = 1;
  for (std::size_t n = 0; n < rank; ++n) {
    const std::size_t axis = is_fortran ? n : rank - 1 - n;
    array.stride[axis] = step;
    step *= array.chunk[axis];
  }
}

}  // namespace

std::uint64_t ZarrArray::chunk_numbers() const noexcept {
  std::uint64_t numbers = 1;
  for (const std::int64_t n : chunk) numbers *= static_cast<std::uint64_t>(n);
  return numbers;
}

std::uint64_t ZarrArray::chunks_in_file() const noexcept {
  std::uint64_t chunks = 1;
  for (std::size_t n = 0; n < chunk.size(); ++n) chunks *= static_cast<std::uint64_t>(shard[n] / chunk[n]);
  return chunks;
}

std::string ZarrArray::file_of(std::span<const std::int64_t> at) const {
  std::string name = path.empty() ? prefix : path + "/" + prefix;
  for (std::size_t n = 0; n < at.size(); ++n) {
    if (n > 0) name += separator;
    name += std::to_string(at[n]);
  }
  return name;
}

ZarrArray read_zarr_array(const ZarrFolder& folder, const std::string& path, std::uint64_t most_chunk_bytes) {
  const std::string old_name = joined_path(path, ".zarray"), new_name = joined_path(path, "zarr.json");
  std::optional<ZarrJson> json = folder.json(new_name);
  const bool is_new = json.has_value();
  if (!is_new) json = folder.json(old_name);
  if (!json) throw LoadError("has no '" + old_name + "' and no '" + new_name + "'; get the whole store");
  const ZarrMetadata of{is_new ? new_name : old_name, *json};
  const ZarrJson* format = ZarrMetadata::member(of.root, "zarr_format");
  if (format == nullptr || *format != (is_new ? 3 : 2))
    throw of.error("whose 'zarr_format' is not " + std::string(is_new ? "3" : "2") + "; write the store again");
  ZarrArray array = is_new ? version_3(of, path) : version_2(of, path);
  check_sizes(array, of, most_chunk_bytes);
  if (!is_new) {
    if (const auto attributes = folder.json(joined_path(path, ".zattrs")))
      take_axes(array, ZarrMetadata::member(*attributes, "_ARRAY_DIMENSIONS"));
  }
  return array;
}

}  // namespace palpa::reader
