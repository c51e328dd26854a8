// Ends the program when a call does not return: a graphics driver may wait for ever after a fault of its GPU.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace sideray::viewer {

class Watchdog {
 public:
  // `expire` is called on another thread when a watched call takes longer than `limit`. It does not return.
  Watchdog(std::chrono::milliseconds limit, std::function<void()> expire);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  // Watches the calls that one thread makes while this lives. Watches may be nested; the limit is that of the newest.
  class Watch {
   public:
    explicit Watch(Watchdog& watchdog) : watchdog_(watchdog) { watchdog_.change(+1); }
    ~Watch() { watchdog_.change(-1); }
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

   private:
    Watchdog& watchdog_;
  };

 private:
  void change(int watches);
  void run(std::chrono::milliseconds limit, const std::function<void()>& expire);

  std::mutex mutex_;
  std::condition_variable changed_;
  int watches_ = 0;
  uint32_t ticks_ = 0;  // since the last change of `watches_`
  bool stops_ = false;
  std::thread thread_;
};

}  // namespace sideray::viewer
