// C++ exceptions for WebAssembly: Debian's libc++abi is built without. These are the functions that code compiled with
// -fwasm-exceptions calls (Itanium C++ ABI, level II), for one thread and for exceptions of C++ alone. There are no
// exception specifications and no dependent exceptions.
//
// A module must survive where memory ends, so that operator new throws, too.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <new>
#include <typeinfo>

namespace {

// Stands in front of every exception object.
struct alignas(16) Header {
    const std::type_info* type;
    void* (*destroy)(void*);  // destructors return their object here
    void* adjusted;           // the object as the handler's type sees it
    int handlers;             // number of handlers that hold it
    bool rethrown;
    Header* next;  // an exception that was caught before
};

// Where memory has ended there is still room for one small exception at a time, such as std::bad_alloc.
struct Spare {
    Header header;
    unsigned char object[64];
} spare;

Header* caught = nullptr;  // by handlers that have not ended, the newest first

Header* headerOf(void* object) { return static_cast<Header*>(object) - 1; }

// A type_info of libc++abi: two destructors, two functions without a purpose, then can_catch.
struct CatchType : std::type_info {
    virtual void noop1() const;
    virtual void noop2() const;
    virtual bool can_catch(const CatchType* thrown, void*& adjusted) const = 0;
};

// Reads LEB128 numbers of the table of a function's handlers.
struct Reader {
    const std::uint8_t* at;

    std::uintptr_t number() {
        std::uintptr_t value = 0;
        for (int shift = 0;; shift += 7) {
            const std::uint8_t byte = *at++;
            value |= std::uintptr_t(byte & 127) << shift;
            if (!(byte & 128)) return value;
        }
    }
    std::intptr_t signedNumber() {
        std::intptr_t value = 0;
        for (int shift = 0;;) {
            const std::uint8_t byte = *at++;
            value |= std::intptr_t(byte & 127) << shift;
            shift += 7;
            if (byte & 128) continue;
            return shift < 32 && (byte & 64) ? value - (std::intptr_t(1) << shift) : value;
        }
    }
};

// Indices of the values that a landing pad and the personality exchange. The pad gives the index of the call site and
// the table of the function. The personality answers with the type that matched; 0: none.
enum LandingPad { kCallSite, kHandlers, kSelector, kLandingPadSize };

constexpr std::uint8_t kOmitted = 0xff;

// Follows a chain of actions to the first type that catches the exception. Returns its number, or 0 for none.
std::uintptr_t matching(Header* header, const CatchType* const* types, const std::uint8_t* action) {
    for (;;) {
        Reader reader{action};
        const std::intptr_t filter = reader.signedNumber();
        if (filter == 0) return 0;  // a clean-up
        if (filter > 0) {
            const CatchType* type = types[-filter];
            void* adjusted = header + 1;
            if (!type || type->can_catch(static_cast<const CatchType*>(header->type), adjusted)) {
                header->adjusted = adjusted;
                return std::uintptr_t(filter);
            }
        }
        const std::uint8_t* here = reader.at;
        const std::intptr_t next = reader.signedNumber();
        if (next == 0) return 0;
        action = here + next;
    }
}

}  // namespace

extern "C" {

thread_local std::uintptr_t __wasm_lpad_context[kLandingPadSize] = {};

void* __cxa_allocate_exception(std::size_t size) noexcept;
void __cxa_free_exception(void* object) noexcept;
[[noreturn]] void __cxa_throw(void* object, std::type_info* type, void* (*destroy)(void*));
void* __cxa_get_exception_ptr(void* object) noexcept;
void* __cxa_begin_catch(void* object) noexcept;
void __cxa_end_catch();
[[noreturn]] void __cxa_rethrow();
int _Unwind_CallPersonality(void* object);
int __cxa_thread_atexit(void (*destroy)(void*), void* object, void* module);
int __gxx_wasm_personality_v0();

void* __cxa_allocate_exception(std::size_t size) noexcept {
    void* memory = std::calloc(1, sizeof(Header) + size);
    if (!memory && size <= sizeof(spare.object)) memory = &(spare = {});
    if (!memory) std::abort();
    return static_cast<Header*>(memory) + 1;
}

void __cxa_free_exception(void* object) noexcept {
    Header* header = headerOf(object);
    if (header != &spare.header) std::free(header);
}

[[noreturn]] void __cxa_throw(void* object, std::type_info* type, void* (*destroy)(void*)) {
    Header* header = headerOf(object);
    header->type = type;
    header->destroy = destroy;
    header->adjusted = object;
    __builtin_wasm_throw(0, object);
}

void* __cxa_get_exception_ptr(void* object) noexcept { return headerOf(object)->adjusted; }

void* __cxa_begin_catch(void* object) noexcept {
    Header* header = headerOf(object);
    ++header->handlers;
    header->rethrown = false;
    if (caught != header) {
        header->next = caught;
        caught = header;
    }
    return header->adjusted;
}

void __cxa_end_catch() {
    Header* header = caught;
    if (!header || --header->handlers > 0) return;
    caught = header->next;
    if (header->rethrown) return;
    if (header->destroy) header->destroy(header + 1);
    __cxa_free_exception(header + 1);
}

[[noreturn]] void __cxa_rethrow() {
    if (!caught) std::abort();
    caught->rethrown = true;
    __builtin_wasm_throw(0, caught + 1);
}

// Looks for a handler of the exception at the call site of the landing pad (LSDA of the Itanium C++ ABI).
int _Unwind_CallPersonality(void* object) {
    Header* header = headerOf(object);
    std::uintptr_t* pad = __wasm_lpad_context;
    pad[kSelector] = 0;
    Reader sites{reinterpret_cast<const std::uint8_t*>(pad[kHandlers])};
    if (!sites.at) return 0;
    if (*sites.at++ != kOmitted) std::abort();  // where landing pads begin: WebAssembly has no addresses of code
    const CatchType* const* types = nullptr;
    if (*sites.at++ != kOmitted) {
        const std::uintptr_t offset = sites.number();
        types = reinterpret_cast<const CatchType* const*>(sites.at + offset);
    }
    ++sites.at;  // how numbers of call sites are written: always as here
    const std::uintptr_t size = sites.number();
    const std::uint8_t* actions = sites.at + size;
    for (std::uintptr_t i = 0; sites.at < actions; ++i) {
        sites.number();  // the landing pad, which called us
        const std::uintptr_t first = sites.number();
        if (i != pad[kCallSite]) continue;
        if (first == 0) return 0;
        pad[kSelector] = matching(header, types, actions + first - 1);
        return 0;
    }
    return 0;
}

// Memory goes with the module, so that nothing is destroyed when a thread ends.
int __cxa_thread_atexit(void (*)(void*), void*, void*) { return 0; }

int __gxx_wasm_personality_v0() { return 0; }
}

void* operator new(std::size_t size) {
    void* memory = std::malloc(size ? size : 1);
    if (!memory) throw std::bad_alloc();
    return memory;
}
void* operator new[](std::size_t size) { return operator new(size); }
void* operator new(std::size_t size, std::align_val_t alignment) {
    const std::size_t step = std::size_t(alignment) < sizeof(void*) ? sizeof(void*) : std::size_t(alignment);
    void* memory = size > SIZE_MAX - step ? nullptr : std::aligned_alloc(step, (size + step - 1) / step * step);
    if (!memory) throw std::bad_alloc();
    return memory;
}
void* operator new[](std::size_t size, std::align_val_t alignment) { return operator new(size, alignment); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
