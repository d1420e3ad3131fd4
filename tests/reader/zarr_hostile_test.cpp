// Hostile and damaged stores: a line or a damaged chunk, whatever they say; and little memory.
#include <gmock/gmock.h>

#include <fstream>

#include "store_test.h"

namespace palpa::test {
namespace zarr_hostile_test {

using testing::AllOf;
using testing::HasSubstr;

class HostileStore : public StoreTest {
 protected:
  void SetUp() override {
    StoreTest::SetUp();
    for (int format = 2; format <= 3; ++format) {
      ZarrToWrite array{.format = format, .shape = {32, 32, 32}, .chunk = {16, 16, 16}, .type = "uint16", .codec = "blosc"};
      if (format == 3) array.shard = {32, 32, 32};
      write(format == 2 ? "v2" : "v3", array);
    }
  }
  static std::string content(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
  }
  /// Error of a store whose metadata have a text replaced.
  std::string with(const std::string& file, const std::string& from, const std::string& to) const {
    const std::string text = content(at(file));
    const std::size_t place = text.find(from);
    EXPECT_NE(place, std::string::npos) << from;
    write_text_file(at(file), std::string(text).replace(place, from.size(), to));
    const std::string error = error_of_store(at(file.substr(0, 2)));
    write_text_file(at(file), text);
    return error;
  }
  /// Sentence of the first chunk, which must be damaged.
  std::string damage(const std::string& store) const {
    StoreReader reader = open(at(store));
    StoreRead how;
    numbers(reader, {}, &how);
    EXPECT_EQ(how.state, ChunkState::damaged);
    return how.sentence;
  }
};

TEST_F(HostileStore, MetadataOfVersion2AreRefusedInOneLine) {
  EXPECT_THAT(with("v2/0/.zarray", "[32,32,32]", "[32,-32,32]"), HasSubstr("'0/.zarray' whose 'shape' is no list"));
  EXPECT_THAT(with("v2/0/.zarray", "[32,32,32]", "[32,32,1e300]"), HasSubstr("whole numbers"));
  EXPECT_THAT(with("v2/0/.zarray", "[32,32,32]", "[32,32,99999999999]"), HasSubstr("more than 262144"));
  EXPECT_THAT(with("v2/0/.zarray", "[32,32,32]", "[1,1,1,1,1,1,1,1,1]"), HasSubstr("up to 8"));
  EXPECT_THAT(with("v2/0/.zarray", "[16,16,16]", "[16,16]"), HasSubstr("different numbers of indices"));
  EXPECT_THAT(with("v2/0/.zarray", "[16,16,16]", "[16,0,16]"), HasSubstr("'chunks'"));
  EXPECT_THAT(with("v2/0/.zarray", "[16,16,16]", "[99999999999,99999999999,99999999999]"),
              HasSubstr("chunks of more than 33.6 MB"));
  EXPECT_THAT(with("v2/0/.zarray", "[16,16,16]", "[1000,1000,17]"), HasSubstr("chunks of more than"));
  EXPECT_THAT(with("v2/0/.zarray", "<u2", "<m8[ns]"), HasSubstr("of the type '<m8[ns]'"));
  EXPECT_THAT(with("v2/0/.zarray", "\"<u2\"", "[[\"r\",\"|u1\"]]"), HasSubstr("with parts"));
  EXPECT_THAT(with("v2/0/.zarray", "\"fill_value\":0", "\"fill_value\":70000"), HasSubstr("no number of the type uint16"));
  EXPECT_THAT(with("v2/0/.zarray", "\"fill_value\":0", "\"fill_value\":\"NaN\""), HasSubstr("'fill_value'"));
  EXPECT_THAT(with("v2/0/.zarray", "\"C\"", "\"X\""), HasSubstr("'order'"));
  EXPECT_THAT(with("v2/0/.zarray", "\"/\"", "\"../\""), HasSubstr("'dimension_separator'"));
  EXPECT_THAT(with("v2/0/.zarray", "lz4", "snappy"), HasSubstr("'snappy', which is not read"));
  EXPECT_THAT(with("v2/0/.zarray", "\"zarr_format\":2", "\"zarr_format\":7"), HasSubstr("'zarr_format' is not 2"));
  EXPECT_THAT(with("v2/0/.zarray", "{", "["), HasSubstr("no JSON object"));
  for (const char* path : {"../v3/0", "/etc", "..", "0/../../v3/0", "0//", "a\\u0000b", ""})
    EXPECT_THAT(with("v2/.zattrs", "\"path\":\"0\"", std::string("\"path\":\"") + path + "\""), HasSubstr("no plain path"))
        << path;
  EXPECT_THAT(with("v2/.zattrs", "\"scale\":[1,1,1]", "\"scale\":[1,0,1]"), HasSubstr("not above 0"));
  EXPECT_THAT(with("v2/.zattrs", "\"scale\":[1,1,1]", "\"scale\":[1,1]"), HasSubstr("no list of 3 numbers"));
  EXPECT_THAT(with("v2/.zattrs", "\"scale\":[1,1,1]", "\"scale\":[1e308,1e308,1e308]"), HasSubstr("; "));
  EXPECT_THAT(with("v2/.zattrs", "\"name\":\"z\"", "\"name\":\"x\""), HasSubstr("with an axis 'x'"));
  EXPECT_THAT(with("v2/.zattrs", "{\"name\":\"z\",\"type\":\"space\",\"unit\":\"micrometer\"},", ""), HasSubstr("with 2 axes"));
}

TEST_F(HostileStore, MetadataOfVersion3AreRefusedInOneLine) {
  EXPECT_THAT(with("v3/0/zarr.json", "\"bytes\"", "\"transpose\""), HasSubstr("C order"));
  EXPECT_THAT(with("v3/0/zarr.json", "\"chunk_shape\":[16,16,16]", "\"chunk_shape\":[5,16,16]"),
              HasSubstr("no whole number of chunks"));
  EXPECT_THAT(with("v3/0/zarr.json", "\"chunk_shape\":[32,32,32]", "\"chunk_shape\":[16000000,16000000,16]"),
              HasSubstr("million chunks"));
  EXPECT_THAT(
      with("v3/0/zarr.json", "\"chunk_shape\":[32,32,32]", "\"chunk_shape\":[1099511627776,1099511627776,1099511627776]"),
      HasSubstr("million chunks"));
  EXPECT_THAT(with("v3/0/zarr.json", "\"regular\"", "\"rectangular\""), HasSubstr("no regular grid"));
  EXPECT_THAT(with("v3/0/zarr.json", "\"uint16\"", "\"int64\""), HasSubstr("convert it to int32 or float64"));
  EXPECT_THAT(with("v3/0/zarr.json", "\"crc32c\"", "\"gzip\""), HasSubstr("index that is compressed"));
  EXPECT_THAT(with("v3/0/zarr.json", "\"index_location\":\"end\"", "\"index_location\":\"middle\""),
              HasSubstr("neither at the end"));
  EXPECT_THAT(with("v3/0/zarr.json", "\"name\":\"blosc\"", "\"name\":\"sharding_indexed\""), HasSubstr("shards within shards"));
  EXPECT_THAT(with("v3/0/zarr.json", "\"node_type\":\"array\"", "\"node_type\":\"group\""), HasSubstr("of a group"));
  EXPECT_THAT(with("v3/zarr.json", "\"multiscales\":[{", "\"multiscales\":[4,{"), HasSubstr("'datasets'"));
}

TEST_F(HostileStore, DeepAndLongJsonIsRefusedBeforeItIsParsed) {
  write_text_file(at("v2/.zattrs"), "{\"multiscales\":" + std::string(1'000'000, '[') + std::string(1'000'000, ']') + "}");
  EXPECT_THAT(error_of_store(at("v2")), HasSubstr("more than 16 levels"));
  write_text_file(at("v2/.zattrs"), "{\"a\":\"" + std::string(5'000'000, 'x') + "\"}");
  EXPECT_THAT(error_of_store(at("v2")), HasSubstr("more than 4 MiB"));
  std::string many = "{\"a\":[";
  for (int n = 0; n < 1'000'000; ++n) many += "NaN,";
  write_text_file(at("v2/.zattrs"), many + "1]}");
  EXPECT_THAT(error_of_store(at("v2")), HasSubstr("is a group of Zarr without 'multiscales'"));
}

TEST_F(HostileStore, LinksAreFollowedInsideTheFolderOnly) {
  fs::create_directories(at("outside"));
  fs::copy(at("v2/0/0/0/0"), at("outside/chunk"));
  fs::remove(at("v2/0/0/0/0"));
  fs::create_symlink(at("outside/chunk"), at("v2/0/0/0/0"));
  EXPECT_THAT(damage("v2"), HasSubstr("'0/0/0/0': "));
  fs::remove(at("v2/0/0/0/0"));
  fs::create_symlink("/etc/ld.so.cache", at("v2/0/0/0/0"));  // where the sandbox itself lets it read
  EXPECT_THAT(damage("v2"), HasSubstr("'0/0/0/0': is a link that leads out of the store"));
  fs::remove(at("v2/0/0/0/0"));
  fs::create_symlink("1", at("v2/0/0/0/0"));
  StoreReader reader = open(at("v2"));
  EXPECT_EQ(numbers(reader, {}).size(), 4096u);
  fs::remove_all(at("v2/0"));
  fs::create_directory_symlink(at("v3/0"), at("v2/0"));
  EXPECT_THAT(error_of_store(at("v2")), HasSubstr("; "));
  fs::create_directory_symlink(at("v3"), at("link"));
  EXPECT_EQ(open(at("link")).contents().octaves.size(), 1u);
}

TEST_F(HostileStore, DamagedChunksNameTheirFile) {
  const fs::path chunk = at("v2/0/0/0/0");
  const std::string sound = content(chunk);
  const auto after = [&](const std::string& bytes) {
    write_text_file(chunk, bytes);
    return damage("v2");
  };
  const auto changed = [&](std::size_t place, const std::string& to) {
    return std::string(sound).replace(place, to.size(), to);
  };
  EXPECT_THAT(after(""), HasSubstr("'0/0/0/0': has an invalid header of blosc"));
  EXPECT_THAT(after(sound.substr(0, sound.size() / 2)), HasSubstr("'0/0/0/0': "));
  EXPECT_THAT(after(changed(4, bytes_of<std::uint32_t>(4096))), HasSubstr("'0/0/0/0': "));
  EXPECT_THAT(after(changed(4, bytes_of<std::uint32_t>(0x7fffffff))), HasSubstr("'0/0/0/0': "));
  EXPECT_THAT(after(changed(8, bytes_of<std::uint32_t>(0xffffffff))), HasSubstr("'0/0/0/0': "));
  EXPECT_THAT(after(changed(12, bytes_of<std::uint32_t>(3))), HasSubstr("'0/0/0/0': "));
  EXPECT_THAT(after(std::string(1'000'000, '\0')), HasSubstr("is longer than any chunk of 8192 bytes"));
  fs::remove(chunk);
  fs::create_directory(chunk);
  EXPECT_THAT(damage("v2"), HasSubstr("'0/0/0/0': is a folder"));
  fs::remove(chunk);
  fs::create_symlink("0", chunk);
  EXPECT_THAT(damage("v2"), HasSubstr("'0/0/0/0': cannot be read"));
  EXPECT_THAT(error_of([&] { read(at("v2")); }),
              AllOf(HasSubstr("holds a damaged chunk: '0/0/0/0'"), HasSubstr("; get the whole store")));
}

TEST_F(HostileStore, ChunksOfOtherCodecsThatAreCutOrTooLongAreDamaged) {
  for (const char* codec : {"raw", "gzip", "zlib", "zstd"}) {
    SCOPED_TRACE(codec);
    const ZarrToWrite array{.shape = {16, 16, 16}, .chunk = {16, 16, 16}, .type = "uint16", .codec = codec};
    const std::string name = std::string("of ") + codec;
    write(name, array);
    const fs::path chunk = at(name) / "0/0/0/0";
    const std::string sound = content(chunk);
    write_text_file(chunk, sound.substr(0, sound.size() - 3));
    EXPECT_THAT(damage(name), HasSubstr("'0/0/0/0': "));
    ZarrToWrite larger = array;
    larger.chunk = larger.shape = {16, 16, 17};
    write("larger", larger);
    write_text_file(chunk, content(at("larger/0/0/0/0")));
    EXPECT_THAT(damage(name), HasSubstr("bytes"));
    larger.chunk = larger.shape = {16, 16, 15};
    write("larger", larger);
    write_text_file(chunk, content(at("larger/0/0/0/0")));
    EXPECT_THAT(damage(name), HasSubstr("'0/0/0/0': "));
  }
}

TEST_F(HostileStore, IndicesOfShardsThatAreWrongAreDamage) {
  const fs::path shard = at("v3/0/c/0/0/0");
  const std::string sound = content(shard);
  write_text_file(shard, sound.substr(0, 100));
  EXPECT_THAT(damage("v3"), HasSubstr("'0/c/0/0/0': is shorter than its index"));
  write_text_file(shard, sound.substr(0, sound.size() - 1));
  EXPECT_THAT(damage("v3"), HasSubstr("'0/c/0/0/0': its index has another checksum"));
  // The index is without a checksum, so that it can lie.
  std::string metadata = content(at("v3/0/zarr.json"));
  const std::size_t checksum = metadata.find(",{\"name\":\"crc32c\"}");
  write_text_file(at("v3/0/zarr.json"), metadata.erase(checksum, 18));
  const std::size_t index = sound.size() - 4 - 8 * 16;
  for (const auto& [offset, bytes] : {std::pair{std::uint64_t{sound.size()}, std::uint64_t{10}},
                                      {0, 1ull << 62},
                                      {1ull << 63, 1ull << 63},
                                      {UINT64_MAX, 1},
                                      {UINT64_MAX - 4, 8}}) {
    std::string lying = sound.substr(0, sound.size() - 4);
    lying.replace(index, 16, bytes_of(offset) + bytes_of(bytes));
    write_text_file(shard, lying);
    EXPECT_THAT(damage("v3"), HasSubstr("'0/c/0/0/0': its index points beyond its end"));
  }
}

TEST_F(HostileStore, AHugeStoreOpensAtOnceAndWithoutMemory) {
  write_zarr_group(at("huge"), multiscales(1, false));
  write_text_file(at("huge/0/.zarray"),
                  R"({"zarr_format":2,"shape":[262144,262144,262144],"chunks":[32,32,32],"dtype":"<f8","compressor":null,)"
                  R"("fill_value":null,"order":"C","filters":null})");
  StoreReader reader = open(at("huge"));
  StoreRead how;
  numbers(reader, {.at = {8191, 8191, 8191}}, &how);
  EXPECT_EQ(how.state, ChunkState::absent);
  EXPECT_THAT(error_of([&] { read(at("huge")); }), HasSubstr("`palpa prepare` makes the rest"));
}

TEST_F(HostileStore, ManyTinyChunksAreRefusedAsOneVolume) {
  write_zarr_group(at("tiny"), multiscales(1, false));
  write_text_file(at("tiny/0/.zarray"),
                  R"({"zarr_format":2,"shape":[200,200,200],"chunks":[1,1,1],"dtype":"|u1","compressor":null,)"
                  R"("fill_value":1,"order":"C","filters":null})");
  EXPECT_THAT(error_of([&] { read(at("tiny")); }), HasSubstr("a million"));
}

}  // namespace zarr_hostile_test
}  // namespace palpa::test
