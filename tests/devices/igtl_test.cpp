// Trackers of OpenIGTLink: messages held to libopenigtlink, and the driver under wrong, cut and hostile ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <igtlClientSocket.h>
#include <igtlImageMessage.h>
#include <igtlServerSocket.h>
#include <igtlStatusMessage.h>
#include <igtlStringMessage.h>
#include <igtlTransformMessage.h>
#include <igtl_util.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <random>
#include <thread>

#include "devices/igtl_messages.h"
#include "palpa/base/load_error.h"
#include "palpa/device/open_device.h"
#include "palpa/solver/pose.h"
#include "tests/devices/igtl_stand_in.h"

namespace palpa {
namespace igtl_test {

using std::chrono::milliseconds;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using Clock = std::chrono::steady_clock;

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

/// Messages that a stream gives for these bytes, in pieces of this size, as TYPE NAME BYTES.
std::vector<std::string> read(const std::string& text, std::size_t piece = 7) {
  igtl::MessageStream stream;
  std::vector<std::string> found;
  const auto note = [&](const igtl::Head& head, std::span<const std::byte> body) {
    found.push_back(std::string(igtl::word_of(head.type)) + ' ' + std::string(igtl::word_of(head.name)) + ' ' +
                    std::to_string(body.size()));
  };
  for (std::size_t at = 0; at < text.size(); at += piece)
    if (!stream.take(bytes_of(text).subspan(at, std::min(piece, text.size() - at)), note)) found.push_back("unusable");
  return found;
}

void set_matrix(::igtl::Matrix4x4& matrix, const test::SentPose& pose) {
  ::igtl::IdentityMatrix(matrix);
  const double place_mm[3] = {pose.place_mm.x, pose.place_mm.y, pose.place_mm.z};
  for (int i = 0; i < 3; ++i) {
    const Vec3& row = pose.rotation.row[i];
    const double of[3] = {row.x, row.y, row.z};
    for (int j = 0; j < 3; ++j) matrix[i][j] = static_cast<float>(of[j]);
    matrix[i][3] = static_cast<float>(place_mm[i]);
  }
}

::igtl::TransformMessage::Pointer packed(const std::string& name, const test::SentPose& pose) {
  auto message = ::igtl::TransformMessage::New();
  message->SetDeviceName(name.c_str());
  ::igtl::Matrix4x4 matrix;
  set_matrix(matrix, pose);
  message->SetMatrix(matrix);
  message->Pack();
  return message;
}
template <class Message>
std::string text_of(const Message& message) {
  return {static_cast<const char*>(message->GetPackPointer()), static_cast<std::size_t>(message->GetPackSize())};
}

const test::SentPose turned{.rotation = {{{0.6, -0.8, 0}, {0.8, 0.6, 0}, {0, 0, 1}}}, .place_mm = {10.5, -20.25, 30}};

TEST(IgtlMessages, AreReadAsTheLibraryWritesThem) {
  const std::string sent = text_of(packed("Stylus", turned));
  EXPECT_THAT(read(sent), testing::ElementsAre("TRANSFORM Stylus 48"));
  const std::optional<igtl::RasPose> pose = igtl::pose_of(bytes_of(sent).subspan(igtl::head_bytes));
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->place_mm, turned.place_mm);
  EXPECT_NEAR(pose->rotation.row[0].y, -0.8, 1e-7);
  // The stand-in of the other tests writes the same bytes, but for the time.
  std::string own = test::transform_message("Stylus", turned);
  own.replace(34, 8, sent, 34, 8);
  EXPECT_EQ(own, sent);
}

TEST(IgtlMessages, HaveTheLibrarysChecksum) {
  std::mt19937 random(1);
  for (int n = 0; n < 200; ++n) {
    std::string text(random() % 300, '\0');
    for (char& letter : text) letter = static_cast<char>(random());
    EXPECT_EQ(igtl::crc64(bytes_of(text)), ::crc64(reinterpret_cast<unsigned char*>(text.data()), text.size(), 0));
  }
}

/// The message as the library unpacks it, with its checksum.
template <class Message>
typename Message::Pointer unpacked(const igtl::Bytes& bytes) {
  auto head = ::igtl::MessageHeader::New();
  head->InitPack();
  std::memcpy(head->GetPackPointer(), bytes.data(), igtl::head_bytes);
  head->Unpack();
  auto message = Message::New();
  message->SetMessageHeader(head);
  message->AllocatePack();
  EXPECT_EQ(static_cast<std::size_t>(message->GetPackBodySize()), bytes.size() - igtl::head_bytes);
  std::memcpy(message->GetPackBodyPointer(), bytes.data() + igtl::head_bytes, bytes.size() - igtl::head_bytes);
  EXPECT_TRUE(message->Unpack(1) & ::igtl::MessageHeader::UNPACK_BODY);
  return message;
}

TEST(IgtlMessages, AreUnpackedByTheLibrary) {
  const auto transform = unpacked<::igtl::TransformMessage>(
      igtl::message_of("TRANSFORM", "PalpaProbe", igtl::transform_body({turned.rotation, turned.place_mm})));
  ::igtl::Matrix4x4 is, right;
  transform->GetMatrix(is);
  set_matrix(right, turned);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) EXPECT_EQ(is[i][j], right[i][j]);
  EXPECT_STREQ(transform->GetDeviceName(), "PalpaProbe");
  unsigned int time_s = 0, fraction = 0;
  transform->GetTimeStamp(&time_s, &fraction);
  EXPECT_NEAR(time_s, static_cast<double>(std::time(nullptr)), 5);

  const auto status = unpacked<::igtl::StatusMessage>(
      igtl::message_of("STATUS", "Palpa", igtl::status_body(igtl::Status::panic, "off", "stopped by a person")));
  EXPECT_EQ(status->GetCode(), ::igtl::StatusMessage::STATUS_PANICK_MODE);
  EXPECT_STREQ(status->GetErrorName(), "off");
  EXPECT_STREQ(status->GetStatusString(), "stopped by a person");

  const auto string =
      unpacked<::igtl::StringMessage>(igtl::message_of("STRING", "PalpaEvent", igtl::string_body("skin holds")));
  EXPECT_STREQ(string->GetString(), "skin holds");

  constexpr std::string_view types[] = {"TRANSFORM", "GET_IMAGE"};
  const igtl::Bytes known = igtl::capability_body(types);  // by hand: the library leaks what it unpacks
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(known.data()), known.size()),
            std::string("TRANSFORM\0\0\0GET_IMAGE\0\0\0", 24));
}

TEST(IgtlMessages, OfVersionThreeAreReadWithoutTheirMetadata) {
  const std::string transform = test::transform_message("Stylus", turned).substr(igtl::head_bytes);
  const std::string extended("\x00\x0c\x00\x02\x00\x00\x00\x05\x00\x00\x00\x07", 12), metadata("\x00\x00key=1", 7);
  const std::string body = extended + transform + metadata;
  EXPECT_THAT(read(test::igtl_message("TRANSFORM", "Stylus", body, 2)), testing::ElementsAre("TRANSFORM Stylus 67"));
  EXPECT_TRUE(igtl::pose_of(igtl::content_of({.version = 2}, bytes_of(body))));
  for (const char* wrong : {"\xff\xff", "\x00\x0b", "\x00\x40"}) {
    std::string damaged = body;
    damaged.replace(0, 2, wrong, 2);
    EXPECT_FALSE(igtl::pose_of(igtl::content_of({.version = 2}, bytes_of(damaged))));
  }
}

TEST(IgtlMessages, ThatAreWrongAreNoPoses) {
  const std::string right = test::transform_message("Stylus", turned);
  std::string wrong = right;
  wrong.back() ^= 1;
  EXPECT_THAT(read(wrong + right), testing::ElementsAre("TRANSFORM Stylus 48")) << "a checksum";
  const std::string large = test::igtl_message("IMAGE", "ct", std::string(100'000, 'x'));
  EXPECT_THAT(read(large + right, 1000), testing::ElementsAre("TRANSFORM Stylus 48")) << "long bodies are passed over";
  wrong = right;
  wrong[42] = 0x10;
  EXPECT_THAT(read(wrong), testing::Contains("unusable")) << "a length of 2^60 bytes";
  EXPECT_THAT(read("GET / HTTP/1.1\r\nHost: 127.0.0.1:18944\r\nAccept: text/html\r\n\r\n"), testing::Contains("unusable"));
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (const test::SentPose& no_pose : {test::SentPose{.place_mm = {nan, 0, 0}}, test::SentPose{.place_mm = {0, 1e6, 0}},
                                        test::SentPose{.rotation = 1.1 * Mat3::identity(), .place_mm = {}},
                                        test::SentPose{.rotation = {{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, .place_mm = {}}})
    EXPECT_FALSE(igtl::pose_of(bytes_of(test::transform_message("a", no_pose)).subspan(igtl::head_bytes)));
}

TEST(IgtlMessages, DamagedAtRandomAreReadWithoutHarm) {
  std::mt19937 random(2);
  for (int n = 0; n < 20'000; ++n) {
    std::string text = test::transform_message("Stylus", turned) + test::igtl_message("STATUS", "a", "b", 2);
    for (auto changes = random() % 4; changes > 0; --changes) text[random() % text.size()] = static_cast<char>(random());
    if (random() % 3 == 0) text.resize(random() % text.size());
    igtl::MessageStream stream;
    stream.take(bytes_of(text), [](const igtl::Head& head, std::span<const std::byte> body) {
      if (const auto pose = igtl::pose_of(igtl::content_of(head, body))) {
        EXPECT_TRUE(is_finite(pose->place_mm) && is_finite(pose->rotation));
      }
    });
  }
}

// ---- the driver ----

class Tracker : public testing::Test {
 protected:
  DeviceSettings settings(DeviceSettings more = {}) {
    more.emplace_back("port", std::to_string(server.port()));
    return more;
  }
  std::unique_ptr<Device> open(const DeviceSettings& more = {}) { return device_backend("igtl").open(settings(more)); }
  template <class Condition>
  testing::AssertionResult comes(Device& device, Condition condition) {
    for (const auto end = Clock::now() + std::chrono::seconds(20); Clock::now() < end;
         std::this_thread::sleep_for(milliseconds(1))) {
      state = device.read();
      if (condition()) return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << "the last fault: " << (state.fault != nullptr ? state.fault : "none");
  }
  testing::AssertionResult is_at(Device& device, const Vec3& place_m) {
    return comes(device, [&] { return state.valid && distance(state.position_m, place_m) < 1e-7; });
  }
  std::string refusal(const DeviceSettings& more) {
    try {
      open(more);
    } catch (const LoadError& error) {
      return error.what();
    }
    return "nothing was refused";
  }

  test::IgtlStandIn server;
  DeviceState state;
};

TEST_F(Tracker, IsWhereItsRasPlaceIsForAUserInFrontOfThePatient) {
  server.hold("Stylus", {.rotation = Mat3::identity(), .place_mm = {-10, 20, 30}});  // to the patient's left, front, head
  EXPECT_TRUE(is_at(*open(), {0.01, 0.03, 0.02}));                                   // right, up, towards the user
}

TEST_F(Tracker, BeginsWhereItIsIfAskedTo) {
  server.hold("Stylus", {.rotation = Mat3::identity(), .place_mm = {-1000, 2000, 500}});
  const auto device = open({{"zero", "here"}});
  EXPECT_TRUE(is_at(*device, {}));
  server.hold("Stylus", {.rotation = Mat3::identity(), .place_mm = {-1000, 2000, 530}});
  EXPECT_TRUE(is_at(*device, {0, 0.03, 0}));
  server.stop();
  EXPECT_TRUE(comes(*device, [&] { return state.fault != nullptr; }));
  server.start();
  EXPECT_TRUE(is_at(*device, {0, 0.03, 0})) << "and not anew, after a gap";
}

TEST_F(Tracker, IsTheOneOfItsName) {
  server.hold("Another", {.rotation = Mat3::identity(), .place_mm = {900, 900, 900}});
  server.hold("Stylus", {.rotation = Mat3::identity(), .place_mm = {0, 0, 30}});
  EXPECT_TRUE(is_at(*open({{"name", "Stylus"}}), {0, 0.03, 0}));
  EXPECT_EQ(open({{"name", "Stylus"}})->name(), "tracker Stylus");
  EXPECT_THAT(refusal({{"name", "Pointer"}}),
              AllOf(HasSubstr("no transform of 'Pointer'"), HasSubstr("it sends Another, Stylus")));
}

TEST_F(Tracker, IsInvalidAfterATenthOfASecondWithoutAPose) {
  server.hold("Stylus", turned);
  const auto device = open();
  EXPECT_TRUE(comes(*device, [&] { return state.valid; }));
  server.hide("Stylus");
  const auto begin = Clock::now();
  EXPECT_TRUE(comes(*device, [&] { return !state.valid; }));
  EXPECT_STREQ(state.fault, "no pose of the tracker for 100 ms; it is hidden, or off");
  EXPECT_GT(Clock::now() - begin, milliseconds(60));
  server.hold("Stylus", turned);
  EXPECT_TRUE(comes(*device, [&] { return state.valid && state.fault == nullptr; }));
}

TEST_F(Tracker, WalksFromPoseToPose) {
  server.hold("Stylus", {.rotation = Mat3::identity(), .place_mm = {}});
  const auto device = open();
  EXPECT_TRUE(is_at(*device, {}));
  server.hold("Stylus", {.rotation = Mat3::identity(), .place_mm = {0, 0, 10}});
  double most_m = 0.0;
  for (Vec3 last_m; last_m.y < 0.01 - 1e-7; last_m = state.position_m, std::this_thread::sleep_for(milliseconds(1))) {
    state = device->read();
    most_m = std::max(most_m, distance(state.position_m, last_m));
  }
  EXPECT_LT(most_m, 0.009) << "10 mm in one pose of a hundred a second";
}

TEST_F(Tracker, LeavesAServerThatNeverEndsAMessage) {
  server.hold("Stylus", turned);
  const auto device = open();
  server.change([](std::string message) { return message[46] = 0x20, message; });  // 512 MB: allowed, and never there
  EXPECT_TRUE(comes(*device, [&] { return server.connections() >= 2; }));
  server.change(nullptr);
  EXPECT_TRUE(comes(*device, [&] { return state.valid; }));
}

TEST_F(Tracker, OfTheLibrarysServerIsFelt) {
  const auto listening = ::igtl::ServerSocket::New();
  ASSERT_EQ(listening->CreateServer(0), 0);
  std::atomic<bool> ends{false};
  std::thread sender([&] {
    ::igtl::ClientSocket::Pointer client;
    while (!ends) {
      if (client.IsNull()) client = listening->WaitForConnection(100);
      if (client.IsNull()) continue;
      const auto message = packed("Stylus", turned);
      if (client->Send(message->GetPackPointer(), message->GetPackSize()) == 0) client = nullptr;
      std::this_thread::sleep_for(milliseconds(10));
    }
  });
  {
    const auto device = device_backend("igtl").open({{"name", "Stylus"}, {"port", std::to_string(listening->GetServerPort())}});
    EXPECT_TRUE(is_at(*device, {-0.0105, 0.03, -0.02025}));
    const Turn turn = turn_by({0, std::atan2(0.8, 0.6), 0});  // about S, the hand's y
    EXPECT_TRUE(comes(*device, [&] { return state.turn && norm(rotation_between_rad(*state.turn, turn)) < 1e-6; }));
  }
  ends = true;
  sender.join();
}

TEST_F(Tracker, IsFoundByItsName) {
  const auto search = [&](const DeviceSettings& more) { return device_backend("igtl").search(settings(more)); };
  EXPECT_THAT(search({}).missing.at(0), HasSubstr("sends no TRANSFORM"));
  server.hold("Stylus", turned);
  const DeviceSearch found = search({});
  ASSERT_EQ(found.found.size(), 1u);
  EXPECT_EQ(found.found[0].description, "igtl,name=Stylus,port=" + std::to_string(server.port()));
  EXPECT_TRUE(device_backend("igtl").open(device_description(found.found[0].description).settings));
  server.hold("a,b='c'", turned);
  EXPECT_EQ(search({}).found.size(), 1u) << "a name that no setting can hold";
  server.stop();
  EXPECT_THAT(search({}).missing.at(0),
              AllOf(HasSubstr("no OpenIGTLink server answers at 127.0.0.1:"), HasSubstr("PlusServer")));
}

TEST_F(Tracker, RefusesWrongSettingsInALine) {
  EXPECT_THAT(refusal({{"colour", "red"}}), HasSubstr("known are name, host, port, zero and remote"));
  EXPECT_THAT(refusal({{"host", "plus.example.org"}}), HasSubstr("give its digits"));
  EXPECT_THAT(refusal({{"host", "192.0.2.1"}}), HasSubstr("give remote=yes"));
  EXPECT_THAT(refusal({{"zero", "there"}}), HasSubstr("give here or ras"));
  EXPECT_THAT(refusal({{"name", ""}}), HasSubstr("1 to 20 letters"));
  EXPECT_THAT(refusal({}), AllOf(StartsWith("device igtl: "), HasSubstr("no pose of the tracker")));
  server.stop();
  EXPECT_THAT(refusal({}), HasSubstr("the tracker's OpenIGTLink server is not there"));
}

}  // namespace igtl_test
}  // namespace palpa
