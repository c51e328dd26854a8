#include "rt/shading/shading_queue.h"

#include <algorithm>
#include <chrono>

namespace sideray::rt {

bool ShadingQueue::run(const Batch& batch, const std::atomic<bool>* cancelled) {
  Entry entry{&batch, cancelled, Entry::State::waiting};
  std::unique_lock lock(mutex_);
  waiting_.push_back(&entry);
  changed_.notify_all();
  // The caller must wait for a batch that has begun, because it reads and writes the caller's memory.
  while (entry.state == Entry::State::running || (entry.state == Entry::State::waiting && !entry.is_given_up()))
    changed_.wait(lock);
  if (entry.state == Entry::State::done) return true;
  waiting_.erase(std::find(waiting_.begin(), waiting_.end(), &entry));
  return false;
}

ShadingQueue::Entry* ShadingQueue::take_next() {
  if (running_) return nullptr;
  const auto next = std::find_if(waiting_.begin(), waiting_.end(), [](const Entry* e) { return !e->is_given_up(); });
  if (next == waiting_.end()) return nullptr;
  Entry* entry = *next;
  waiting_.erase(next);
  return entry;
}

void ShadingQueue::run_entry(Entry& entry, std::unique_lock<std::mutex>& lock) {
  entry.state = Entry::State::running;
  running_ = true;
  lock.unlock();
  (*entry.batch)();
  lock.lock();
  entry.state = Entry::State::done;
  running_ = false;
  changed_.notify_all();
}

void ShadingQueue::serve() {
  std::unique_lock lock(mutex_);
  for (size_t batches = waiting_.size(); batches > 0; --batches) {
    Entry* next = take_next();
    if (!next) return;
    run_entry(*next, lock);
  }
}

void ShadingQueue::serve_until(std::chrono::steady_clock::time_point end, const std::function<bool()>& done) {
  std::unique_lock lock(mutex_);
  while (!done() && std::chrono::steady_clock::now() < end) {
    if (Entry* next = take_next())
      run_entry(*next, lock);
    else
      changed_.wait_until(lock, end);
  }
}

void ShadingQueue::wake() {
  const std::lock_guard lock(mutex_);
  changed_.notify_all();
}

}  // namespace sideray::rt
