#pragma once
// Memory that outlives its user: a solver's vectors keep their room for the next solver of the same kind on the thread.
#include <utility>
#include <vector>

namespace softlimb::solve {

/// A base class with the members of `T`, taken from what an earlier one on this thread left and left to the next. What
/// they hold at first is anything: the user resizes and fills.
template <class T>
class Room : protected T {
protected:
    Room() {
        std::vector<T>& idle = left();
        if (idle.empty()) return;
        static_cast<T&>(*this) = std::move(idle.back());
        idle.pop_back();
    }
    ~Room() {
        // A solve nests a few others at most; more is nothing to keep.
        constexpr std::size_t most = 4;
        std::vector<T>& idle = left();
        if (idle.capacity() < most) idle.reserve(most);
        if (idle.size() < most) idle.push_back(std::move(static_cast<T&>(*this)));
    }
    Room(const Room&) = delete;
    Room& operator=(const Room&) = delete;

private:
    static std::vector<T>& left() {
        thread_local std::vector<T> idle;
        return idle;
    }
};

}  // namespace softlimb::solve
