// Work that takes longer than a picture: on a thread of its own, shown while it goes on, stopped when it is cancelled.
#pragma once

#include <QObject>
#include <QString>
#include <functional>
#include <list>
#include <memory>
#include <stop_token>
#include <thread>

namespace palpa::explorer {

/// One thing is done at a time for each purpose: what is begun anew takes the place of what was under way, which is asked to
/// stop and whose result is dropped. For the window's thread.
class Jobs : public QObject {
  Q_OBJECT
 public:
  enum class Purpose { open, device, draw, look, feel_again, film };
  explicit Jobs(QObject* parent = nullptr);
  /// Asks what is under way to stop, and waits for it.
  ~Jobs() override;

  /// Begins `work` on a thread of its own, where it looks at its token often. `done` gets its result on the window's thread,
  /// `failed` the message of what it threw. \param what  for a person: "reading head.mhd"
  template <class Result>
  void begin(Purpose purpose, const QString& what, std::function<Result(std::stop_token)> work,
             std::function<void(Result)> done, std::function<void(const QString&)> failed) {
    auto result = std::make_shared<std::unique_ptr<Result>>();
    begin_any(
        purpose, what, [work, result](std::stop_token stop) { *result = std::make_unique<Result>(work(stop)); },
        [done, result] { done(std::move(**result)); }, failed);
  }
  void cancel(Purpose purpose);
  void cancel_all();
  bool is_under_way(Purpose purpose) const;
  /// What is under way, for a person; empty: nothing.
  QString words() const;

 Q_SIGNALS:
  /// Something began or ended.
  void changed();

 private:
  struct Job {
    Purpose purpose;
    QString what;
    std::stop_source stop{};  ///< asked to stop: its result is dropped
    std::thread thread{};
  };
  void begin_any(Purpose purpose, const QString& what, std::function<void(std::stop_token)> work, std::function<void()> done,
                 std::function<void(const QString&)> failed);
  std::list<std::shared_ptr<Job>> jobs_;
};

}  // namespace palpa::explorer
