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
        if (!idle.empty()) take(idle.size() - 1);
    }
    /// Of the idle ones the one that `worth` ranks first, the last of equals. One of no worth (zero or less) is left for
    /// whom it serves while there is room for another.
    template <class Worth>
    explicit Room(Worth&& worth) {
        std::vector<T>& idle = left();
        std::size_t best = 0;
        for (std::size_t i = 1; i < idle.size(); ++i)
            if (worth(idle[i]) >= worth(idle[best])) best = i;
        if (!idle.empty() && (worth(idle[best]) > 0 || idle.size() == most)) take(best);
    }
    ~Room() {
        std::vector<T>& idle = left();
        if (idle.capacity() < most) idle.reserve(most);
        if (idle.size() < most) idle.push_back(std::move(static_cast<T&>(*this)));
    }
    Room(const Room&) = delete;
    Room& operator=(const Room&) = delete;

private:
    // A solve nests a few others at most; more is nothing to keep.
    static constexpr std::size_t most = 4;

    void take(std::size_t i) {
        std::vector<T>& idle = left();
        static_cast<T&>(*this) = std::move(idle[i]);
        idle.erase(idle.begin() + static_cast<std::ptrdiff_t>(i));
    }
    static std::vector<T>& left() {
        thread_local std::vector<T> idle;
        return idle;
    }
};

}  // namespace softlimb::solve
