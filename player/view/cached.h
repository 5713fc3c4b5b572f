#pragma once
// Keeps a value with the key that it was made for. What the window shows is made of such values: a key holds all that
// its value depends on, so nobody has to tell whom a change concerns.
#include <optional>
#include <variant>

namespace penumbra {

template <class Key, class Value = std::monostate>
class Cached {
public:
    // Lets make(value) make the value anew, in its place, if the key is another one than that of the last call. Returns
    // whether it was. Where make() throws, the next call makes it again.
    bool update(const Key& key, auto&& make) {
        if (key_ == key) return false;
        key_.reset();
        make(value_);
        key_.emplace(key);
        return true;
    }
    // The same for who keeps the value elsewhere.
    bool update(const Key& key) {
        const bool changed = key_ != key;
        if (changed) key_ = key;
        return changed;
    }
    void forget() { key_.reset(); }

    const std::optional<Key>& key() const { return key_; }  // none: there is no value yet
    const Value& operator*() const { return value_; }
    const Value* operator->() const { return &value_; }
    Value& operator*() { return value_; }
    Value* operator->() { return &value_; }

private:
    std::optional<Key> key_;
    Value value_{};
};

}  // namespace penumbra
