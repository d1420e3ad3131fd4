// The view of a live run for clients of OpenIGTLink, held to libopenigtlink.
#include "app/igtl_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <igtlCapabilityMessage.h>
#include <igtlClientSocket.h>
#include <igtlImageMessage.h>
#include <igtlStatusMessage.h>
#include <igtlStringMessage.h>
#include <igtlTransformMessage.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <thread>

#include "palpa/base/load_error.h"
#include "palpa/file/read_volume.h"
#include "palpa/mode/modes.h"
#include "palpa/scene/load_scene.h"
#include "tests/solver/counted_allocations.h"
#include "tests/solver/counted_locks.h"

namespace palpa {
namespace igtl_view_test {

using app::IgtlView;
using std::chrono::milliseconds;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

/// A ball in the world of a hand that is turned and moved, felt by a hand that presses into it.
Scene ball() {
  constexpr const char* toml = R"(palpa = 1
[coupling]
stiffness_n_per_m = 400
[workspace]
scale = 1.25
center = [0.004, -0.003, 0.002]
towards_user = "-y"
up = "+z"
[volume.ball]
analytic = "sphere"
[[mode]]
name = "skin"
type = "surface_and_friction"
field = "ball"
[[mode.level]]
name = "outside"
value = 0
strength_n = 1
)";
  return parse_scene(toml, "scene", "", volume_reader(), standard_modes()).scene;
}

/// A client of the library's own classes.
class LibraryClient {
 public:
  explicit LibraryClient(std::uint16_t port) : socket_(::igtl::ClientSocket::New()) {
    EXPECT_EQ(socket_->ConnectToServer("127.0.0.1", port), 0);
    socket_->SetTimeout(5000);
  }
  ~LibraryClient() { socket_->CloseSocket(); }
  LibraryClient(const LibraryClient&) = delete;
  LibraryClient& operator=(const LibraryClient&) = delete;

  /// Asks by a message without a body.
  template <class Message>
  void ask(const char* name = "") {
    const auto message = Message::New();
    message->SetDeviceName(name);
    message->Pack();
    ASSERT_EQ(socket_->Send(message->GetPackPointer(), message->GetPackSize()), 1);
  }
  /// The next message of a type and, if given, of a device; null: it does not come.
  template <class Message>
  typename Message::Pointer next(const std::string& type, const std::string& name = {}, bool unpacks = true) {
    for (const auto end = Clock::now() + std::chrono::seconds(10); Clock::now() < end;) {
      const auto head = ::igtl::MessageHeader::New();
      head->InitPack();
      if (!receive(head->GetPackPointer(), head->GetPackSize())) return nullptr;
      head->Unpack();
      if (type != head->GetDeviceType() || (!name.empty() && name != head->GetDeviceName())) {
        std::vector<char> other(static_cast<std::size_t>(head->GetBodySizeToRead()));
        if (!receive(other.data(), static_cast<int>(other.size()))) return nullptr;
        continue;
      }
      typename Message::Pointer message = Message::New();
      message->SetMessageHeader(head);
      message->AllocatePack();
      if (!receive(message->GetPackBodyPointer(), message->GetPackBodySize())) return nullptr;
      if (unpacks) {
        EXPECT_TRUE(message->Unpack(1) & ::igtl::MessageHeader::UNPACK_BODY) << type;
      }
      return message;
    }
    return nullptr;
  }
  bool is_let_go() {
    char byte = 0;
    for (int n = 0; n < 10'000'000; ++n)
      if (socket_->Receive(&byte, 1) <= 0) return true;
    return false;
  }

 private:
  bool receive(void* to, int length) {
    for (int at = 0; at < length;) {  // with a timeout the library gives what has come
      const int received = socket_->Receive(static_cast<char*>(to) + at, length - at);
      if (received <= 0) return false;
      at += received;
    }
    return true;
  }
  ::igtl::ClientSocket::Pointer socket_;
};

/// A view with a session that ticks on this thread.
class View : public testing::Test {
 protected:
  void tick(const Vec3& probe_m, const Turn& turn = {}) {
    const TickFrame frame =
        guarded.tick(number, 1e-3 * static_cast<double>(number), 1e-3, {.position_m = probe_m, .turn = turn});
    ++number;
    view.tick(0, frame, session);
    last = frame.result;
  }
  static Vec3 place_of(::igtl::TransformMessage::Pointer& message) {
    ::igtl::Matrix4x4 matrix;
    message->GetMatrix(matrix);
    return {matrix[0][3], matrix[1][3], matrix[2][3]};
  }

  Scene scene = ball();
  Session session{scene};
  GuardedSession guarded{session, 3.3};
  IgtlView view{0};
  std::int64_t number = 0;
  Tick last;
};

TEST_F(View, ShowsProbeAndProxyInRasMillimetres) {
  for (int n = 0; n < 60; ++n) tick({0, 0, std::max(0.037, 0.06 - 0.0005 * n)});
  LibraryClient client(view.port());  // that has no view of an earlier tick
  const Vec3 probe_m = scene.hand_to_world().to_world(last.probe_m), proxy_m = scene.hand_to_world().to_world(last.proxy_m);
  ASSERT_GT(distance(probe_m, proxy_m), 5e-4) << "it presses";
  for (const auto& [name, world_m] : {std::pair("PalpaProbe", probe_m), std::pair("PalpaProxy", proxy_m)}) {
    auto message = client.next<::igtl::TransformMessage>("TRANSFORM", name);
    ASSERT_TRUE(message.IsNotNull());
    const Vec3 ras_mm{-1e3 * world_m.x, -1e3 * world_m.y, 1e3 * world_m.z};
    EXPECT_LT(distance(place_of(message), ras_mm), 1e-3) << name << " [mm]";
    ::igtl::Matrix4x4 m;
    message->GetMatrix(m);
    // The hand's x, y and z in the world: right is +x, up is +z, towards the user is -y.
    const double expected[3][3] = {{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) EXPECT_NEAR(m[i][j], expected[i][j], 1e-6) << i << ' ' << j;
  }
}

TEST_F(View, ShowsThirtyTimesASecond) {
  LibraryClient client(view.port());
  tick({0, 0, 0.1});
  ASSERT_TRUE(client.next<::igtl::TransformMessage>("TRANSFORM", "PalpaProxy").IsNotNull());
  const auto begin = Clock::now();
  for (int n = 0; n < 30; ++n) ASSERT_TRUE(client.next<::igtl::TransformMessage>("TRANSFORM", "PalpaProxy").IsNotNull());
  EXPECT_NEAR(std::chrono::duration<double>(Clock::now() - begin).count(), 1.0, 0.15);
}

TEST_F(View, TellsEventsAndTheGuard) {
  LibraryClient client(view.port());
  ASSERT_TRUE(client.next<::igtl::StatusMessage>("STATUS").IsNotNull());
  for (int n = 0; n < 400; ++n) tick({0, 0, 0.06 - 0.0002 * n});
  const auto status = client.next<::igtl::StatusMessage>("STATUS");
  ASSERT_TRUE(status.IsNotNull());
  EXPECT_EQ(status->GetCode(), ::igtl::StatusMessage::STATUS_OK);
  auto event = client.next<::igtl::StringMessage>("STRING", "PalpaEvent");
  ASSERT_TRUE(event.IsNotNull());
  EXPECT_THAT(event->GetString(), HasSubstr(" s: skin holds at 0"));
  event = client.next<::igtl::StringMessage>("STRING", "PalpaEvent");
  ASSERT_TRUE(event.IsNotNull());
  EXPECT_THAT(event->GetString(), HasSubstr(" s: skin gives way at 0, "));
  EXPECT_THAT(event->GetString(), HasSubstr(" mm deep"));
}

TEST_F(View, GivesAnImageToThoseWhoAskForIt) {
  LibraryClient client(view.port());
  client.ask<::igtl::GetImageMessage>("ball");
  std::atomic<bool> has_come{false};
  std::thread watching([&] {
    for (; !has_come; std::this_thread::sleep_for(milliseconds(20))) view.watch([&] { return scene; });
  });
  const auto image = client.next<::igtl::ImageMessage>("IMAGE", "ball");
  has_come = true;
  watching.join();
  ASSERT_TRUE(image.IsNotNull());
  int size[3];
  image->GetDimensions(size);
  EXPECT_LE(std::max({size[0], size[1], size[2]}), 256);
  EXPECT_GT(std::min({size[0], size[1], size[2]}), 30);
  EXPECT_EQ(image->GetScalarType(), ::igtl::ImageMessage::TYPE_FLOAT32) << "a formula of metres";
  EXPECT_EQ(image->GetCoordinateSystem(), ::igtl::ImageMessage::COORDINATE_RAS);
  // Every voxel is the field's value at the place that the matrix says, as 3D Slicer reads it: the origin is the centre.
  ::igtl::Matrix4x4 m;
  image->GetMatrix(m);
  float spacing[3];
  image->GetSpacing(spacing);
  const auto value_at = [voxels = static_cast<const char*>(image->GetScalarPointer())](int at) {
    float value = 0.0f;
    std::memcpy(&value, voxels + at * sizeof value, sizeof value);
    return value;
  };
  const Field& field = *scene.volumes().front().volume.fields.front().field;
  for (int k = 0; k < size[2]; k += 17) {
    for (int j = 1; j < size[1]; j += 13) {
      for (int i = 2; i < size[0]; i += 11) {
        const double at[3] = {i - 0.5 * (size[0] - 1), j - 0.5 * (size[1] - 1), k - 0.5 * (size[2] - 1)};
        double ras_mm[3];
        for (int axis = 0; axis < 3; ++axis) {
          ras_mm[axis] = m[axis][3];
          for (int index = 0; index < 3; ++index) ras_mm[axis] += m[axis][index] * spacing[index] * at[index];
        }
        const ScalarSample sample = field.scalar({-1e-3 * ras_mm[0], -1e-3 * ras_mm[1], 1e-3 * ras_mm[2]});
        if (!sample.inside) continue;
        ASSERT_NEAR(value_at((k * size[1] + j) * size[0] + i), sample.value, 1e-5) << i << ' ' << j << ' ' << k;
      }
    }
  }
}

TEST_F(View, RefusesAnImageThatIsNotThereAndTellsWhatItKnows) {
  LibraryClient client(view.port());
  client.next<::igtl::StatusMessage>("STATUS");
  client.ask<::igtl::GetImageMessage>("liver");
  std::this_thread::sleep_for(milliseconds(100));
  view.watch([&] { return scene; });
  const auto status = client.next<::igtl::StatusMessage>("STATUS");
  ASSERT_TRUE(status.IsNotNull());
  EXPECT_EQ(status->GetCode(), ::igtl::StatusMessage::STATUS_NOT_FOUND);
  EXPECT_THAT(status->GetStatusString(), HasSubstr("no scalar volume 'liver'"));
  client.ask<::igtl::GetCapabilityMessage>();
  const auto known = client.next<::igtl::CapabilityMessage>("CAPABILITY", {}, false);  // the library leaks what it unpacks
  ASSERT_TRUE(known.IsNotNull());
  EXPECT_EQ(known->GetPackBodySize(), 8 * 12);
}

TEST_F(View, ForgetsAHandThatHasGone) {
  LibraryClient client(view.port());
  tick({0, 0, 0.06});
  ASSERT_TRUE(client.next<::igtl::TransformMessage>("TRANSFORM", "PalpaProxy").IsNotNull());
  view.leave(0);
  std::this_thread::sleep_for(milliseconds(100));
  LibraryClient later(view.port());
  const auto status = later.next<::igtl::StatusMessage>("STATUS");
  ASSERT_TRUE(status.IsNotNull());
  EXPECT_EQ(status->GetCode(), ::igtl::StatusMessage::STATUS_NOT_READY);
}

TEST_F(View, HasEightClientsAtMost) {
  std::vector<std::unique_ptr<LibraryClient>> clients;
  for (int n = 0; n < 8; ++n) {
    clients.push_back(std::make_unique<LibraryClient>(view.port()));
    ASSERT_TRUE(clients.back()->next<::igtl::StatusMessage>("STATUS").IsNotNull());
  }
  EXPECT_TRUE(LibraryClient(view.port()).is_let_go());
  clients.pop_back();
  std::this_thread::sleep_for(milliseconds(100));
  EXPECT_TRUE(LibraryClient(view.port()).next<::igtl::StatusMessage>("STATUS").IsNotNull());
}

/// A client of plain sockets.
int raw_client(std::uint16_t port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  const int small = 4096;
  ::setsockopt(socket, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  return socket;
}

TEST_F(View, LetsGoOfClientsThatStopReadingOrSendNonsense) {
  LibraryClient good(view.port());
  const int idle = raw_client(view.port()), wild = raw_client(view.port());
  const igtl::Bytes asks = igtl::message_of("GET_IMAGE", "", {});
  for (int n = 0; n < 1000; ++n) ::send(idle, asks.data(), asks.size(), MSG_NOSIGNAL);
  const std::string nonsense = "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nAccept: text/html, application/xml\r\n\r\n";
  ::send(wild, nonsense.data(), nonsense.size(), MSG_NOSIGNAL);
  bool is_idle_gone = false;
  for (const auto end = Clock::now() + std::chrono::seconds(15); !is_idle_gone && Clock::now() < end;) {
    tick({0, 0, 0.1});
    view.watch([&] { return scene; });
    ASSERT_TRUE(good.next<::igtl::TransformMessage>("TRANSFORM").IsNotNull()) << "the others are served";
    is_idle_gone = ::send(idle, asks.data(), asks.size(), MSG_NOSIGNAL) < 0;
  }
  EXPECT_TRUE(is_idle_gone);
  char byte[4096];
  ssize_t length = 0;
  while ((length = ::recv(wild, byte, sizeof byte, 0)) > 0) {
  }
  EXPECT_LE(length, 0);
  ::close(idle);
  ::close(wild);
}

TEST_F(View, TakesNeitherMemoryNorALockOfATick) {
  LibraryClient client(view.port());
  tick({0, 0, 0.06});
  const long allocations = test::allocations, locks = test::locks;
  for (int n = 0; n < 3000; ++n) tick({0, 0, 0.06 - 0.0001 * (n % 400)});
  EXPECT_EQ(test::allocations, allocations);
  EXPECT_EQ(test::locks, locks);
}

TEST_F(View, HasAPortOfItsOwn) {
  try {
    const IgtlView second(view.port());
    ADD_FAILURE();
  } catch (const LoadError& error) {
    EXPECT_THAT(error.what(), HasSubstr("port cannot be had"));
  }
}

}  // namespace igtl_view_test
}  // namespace palpa
