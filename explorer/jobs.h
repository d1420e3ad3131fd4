// Work that takes longer than a picture: on a thread of its own, shown while it goes on, dropped when it is cancelled.
#pragma once

#include <QObject>
#include <QString>
#include <functional>
#include <list>
#include <memory>
#include <thread>

namespace palpa::explorer {

/// One thing is done at a time for each purpose: what is begun anew takes the place of what was under way, whose result is
/// dropped. For the window's thread.
class Jobs : public QObject {
  Q_OBJECT
 public:
  enum class Purpose { open, draw, look, feel_again, film };
  explicit Jobs(QObject* parent = nullptr);
  /// Waits for what is under way.
  ~Jobs() override;

  /// Begins `work` on a thread of its own. `done` gets its result on the window's thread, `failed` the message of what it
  /// threw. \param what  for a person: "reading head.mhd"
  template <class Result>
  void begin(Purpose purpose, const QString& what, std::function<Result()> work, std::function<void(Result)> done,
             std::function<void(const QString&)> failed) {
    auto result = std::make_shared<std::unique_ptr<Result>>();
    begin_any(
        purpose, what, [work, result] { *result = std::make_unique<Result>(work()); },
        [done, result] { done(std::move(**result)); }, failed);
  }
  void cancel(Purpose purpose);
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
    bool is_dropped = false;
    bool is_over = false;
    std::thread thread;
  };
  void begin_any(Purpose purpose, const QString& what, std::function<void()> work, std::function<void()> done,
                 std::function<void(const QString&)> failed);
  std::list<std::shared_ptr<Job>> jobs_;
};

}  // namespace palpa::explorer
