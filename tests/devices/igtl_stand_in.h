// A stand-in for a server of OpenIGTLink with trackers, with faults on request.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "palpa/solver/vec3.h"

namespace palpa::test {

/// Pose as a tracker sends it: RAS, millimetres.
struct SentPose {
  Mat3 rotation = Mat3::identity();
  Vec3 place_mm;
};

/// A TRANSFORM of version 1 of the protocol, by its specification, byte by byte.
std::string transform_message(const std::string& name, const SentPose& pose);
/// Head and body, with the checksum of the body.
std::string igtl_message(const std::string& type, const std::string& name, const std::string& body, std::uint16_t version = 1);

/// Sends the pose of each tracker to each client 100 times a second. Thread-safe.
class IgtlStandIn {
 public:
  IgtlStandIn();
  ~IgtlStandIn();
  IgtlStandIn(const IgtlStandIn&) = delete;
  IgtlStandIn& operator=(const IgtlStandIn&) = delete;

  std::uint16_t port() const { return port_; }  ///< chosen by the system; kept across `start`
  void stop();
  void start();
  void hold(const std::string& name, const SentPose& pose);
  void hide(const std::string& name);
  /// Changes the bytes of each message; nullptr: as they are.
  void change(std::function<std::string(const std::string&)> change);
  int connections() const { return connections_; }  ///< [1] so far
  int clients();                                    ///< [1] now
  bool has_received();                              ///< a byte of a client

 private:
  void run();
  void listen_anew();

  std::mutex mutex_;
  std::map<std::string, SentPose> poses_;
  std::function<std::string(const std::string&)> change_;
  std::vector<int> clients_;
  int listening_ = -1;
  std::uint16_t port_ = 0;
  std::atomic<int> connections_{0};
  std::atomic<bool> has_received_{false}, ends_{false};
  std::thread thread_;
};

}  // namespace palpa::test
