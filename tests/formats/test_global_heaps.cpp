// Text of variable length in HDF5 files, and the datasets that lie elsewhere: what we read of them without HDF5.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>

#include "formats/common/errors.h"
#include "formats/stage/hdf5_handle.h"
#include "formats/stage/hdf5_text.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_global_heaps {
namespace {

template <class T>
void append(std::string& bytes, T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// A heap of 4096 bytes with these texts as its objects 1, 2, ...
std::string heapOf(const std::vector<std::string>& texts) {
    std::string bytes("GCOL\1\0\0\0", 8);
    append<std::uint64_t>(bytes, 4096);
    for (std::size_t i = 0; i < texts.size(); ++i) {
        append<std::uint64_t>(bytes, i + 1);
        append<std::uint64_t>(bytes, texts[i].size());
        bytes += texts[i] + std::string((8 - texts[i].size() % 8) % 8, '\0');
    }
    append<std::uint64_t>(bytes, 0);
    append<std::uint64_t>(bytes, 4096 - (bytes.size() - 8));
    bytes.resize(4096);
    return bytes;
}

using Reference = std::array<std::byte, kTextReferenceBytes>;

Reference referenceTo(std::uint32_t length, std::uint64_t heap, std::uint32_t index) {
    std::string bytes;
    append(bytes, length);
    append(bytes, heap);
    append(bytes, index);
    Reference reference;
    std::memcpy(reference.data(), bytes.data(), bytes.size());
    return reference;
}

std::span<const std::byte> bytesIn(const std::string& text) { return std::as_bytes(std::span(text)); }

TEST(GlobalHeaps, TextsAreFoundByTheirNumbers) {
    const std::string file = std::string(64, 'x') + heapOf({"one", "", "a longer text"});
    GlobalHeaps heaps(bytesIn(file), "f");
    EXPECT_EQ(heaps.text(referenceTo(13, 64, 3)), "a longer text");
    EXPECT_EQ(heaps.text(referenceTo(3, 64, 1)), "one");
    EXPECT_EQ(heaps.text(referenceTo(0, 999, 9)), "");
    EXPECT_EQ(heaps.bytesWalked(), 4096u);
}

TEST(GlobalHeaps, WrongReferencesAreRefused) {
    const std::string file = std::string(64, 'x') + heapOf({"one", "two"});
    GlobalHeaps heaps(bytesIn(file), "f");
    for (const Reference& wrong :
         {referenceTo(2, 64, 1), referenceTo(4, 64, 1), referenceTo(3, 64, 3), referenceTo(3, 64, 0x10001),
          referenceTo(3, 63, 1), referenceTo(3, 4160, 1), referenceTo(3, ~std::uint64_t(0), 1)})
        EXPECT_THROW(heaps.text(wrong), InvalidInput);
}

// Each object of the heap in turn gets every size that reaches out of it.
TEST(GlobalHeaps, ObjectsOutsideOfTheirHeapAreRefused) {
    const std::string whole = heapOf({"one", "two"});
    for (const std::size_t size_at : {8, 24, 48, 72})
        for (const std::uint64_t size : {std::uint64_t(4097), std::uint64_t(1) << 32, ~std::uint64_t(0)}) {
            std::string file = whole;
            std::memcpy(file.data() + size_at, &size, sizeof size);
            EXPECT_THROW(GlobalHeaps(bytesIn(file), "f").text(referenceTo(3, 0, 1)), InvalidInput) << size_at;
        }
}

// A heap starts in every object, and each holds all that follow it.
std::string heapsInHeaps(std::size_t count) {
    std::string bytes;
    for (std::size_t i = 0; i < count; ++i) {
        append<std::uint64_t>(bytes, 1);
        append<std::uint64_t>(bytes, 16);  // this object is the next 16 bytes
        bytes += std::string("GCOL\1\0\0\0", 8);
        append<std::uint64_t>(bytes, 16 + 32 * (count - 1 - i));
    }
    return bytes;
}

// Without a bound, the work would grow with the square of the length.
TEST(GlobalHeaps, ManyHeapsTakeWorkByTheLengthOfTheFile) {
    constexpr std::size_t kHeaps = 1 << 16;
    const std::string file = heapsInHeaps(kHeaps);
    GlobalHeaps heaps(bytesIn(file), "f");
    std::size_t refused = 0;
    for (std::size_t i = 0; i < kHeaps; ++i) {
        try {
            (void)heaps.text(referenceTo(16, 32 * i + 16, 1));
        } catch (const InvalidInput&) {
            ++refused;
        }
    }
    EXPECT_GE(refused, kHeaps - 2);  // all but the first, which holds the others, and the last, which is empty
    EXPECT_LE(heaps.bytesWalked(), file.size());
}

// --- Files ----------------------------------------------------------------------------------------------------------

// Pages of a file that the machine holds in memory.
std::size_t residentPages(const std::filesystem::path& path) {
    const std::size_t length = std::filesystem::file_size(path), page = std::size_t(::sysconf(_SC_PAGESIZE));
    const int file = ::open(path.c_str(), O_RDONLY);
    void* address = ::mmap(nullptr, length, PROT_READ, MAP_PRIVATE, file, 0);
    ::close(file);
    std::vector<unsigned char> pages((length + page - 1) / page);
    EXPECT_EQ(::mincore(address, length, pages.data()), 0);
    ::munmap(address, length);
    return std::size_t(std::count_if(pages.begin(), pages.end(), [](unsigned char p) { return (p & 1) != 0; }));
}

// Nothing but the first kilobytes of these 2 GB was ever written. A page that is read is held in memory afterwards,
// with some of its neighbours where the disk reads ahead.
void writeTwoGigabytes(const std::filesystem::path& path) {
    samples::writeVisibility(path, samples::visibilityHeader(3, 2), Precision::kFloat32);
    std::filesystem::resize_file(path, std::uint64_t(1) << 31);
}
constexpr std::size_t kFewPages = 256;  // one megabyte; 16 pages measured

TEST(OpeningFiles, ReadsAFewPagesOfTwoGigabytes) {
    const samples::Folder folder("two_gigabytes");
    const std::filesystem::path path = folder.path / "x.vis.h5";
    writeTwoGigabytes(path);
    const VisibilityReader reader(path);
    EXPECT_EQ(reader.header().frames.frameCount(), 2u);
    (void)reader.readFrame(0);
    EXPECT_LT(residentPages(path), kFewPages);
}

TEST(OpeningFiles, InfoReadsAFewPagesOfTwoGigabytes) {
    const samples::Folder folder("info_two_gigabytes");
    const std::filesystem::path path = folder.path / "x.vis.h5";
    writeTwoGigabytes(path);
    const std::string command = PENUMBRA_BINARY_DIR "/penumbra-bake info " + path.string() + " >/dev/null";
    ASSERT_EQ(std::system(command.c_str()), 0);
    EXPECT_LT(residentPages(path), kFewPages);
}

// A search for heaps would find half a million behind the file, each with all later ones in it.
TEST(OpeningFiles, DoesNotFollowHeapsThatNothingRefersTo) {
    const samples::Folder folder("many_heaps");
    const std::filesystem::path path = folder.path / "x.vis.h5";
    samples::writeVisibility(path, samples::visibilityHeader(3, 2), Precision::kFloat32);
    std::ofstream(path, std::ios::binary | std::ios::app) << heapsInHeaps(1 << 19);
    EXPECT_EQ(VisibilityReader(path).header().frames.frameCount(), 2u);
}

std::string refusal(const std::filesystem::path& path) {
    std::vector<hsize_t> any{0};
    try {
        (void)readFloats(openHdf5(path), "/values", any);
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "accepted";
}

// HDF5 would decode the list of sources as soon as it opened the dataset. Every byte of the list's heap is spoilt in
// turn; object headers are of version 2 as we write them and of version 1 as others do.
TEST(OpeningFiles, VirtualDatasetsAreRefusedBeforeHdf5OpensThem) {
    const samples::Folder folder("virtual");
    const std::filesystem::path path = folder.path / "x.h5";
    for (const bool latest : {true, false}) {
        {
            Hdf5Handle file = createHdf5(path);
            if (!latest) {
                closeHdf5(file);
                file = Hdf5Handle(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose, "test");
            }
            createVirtualDataset(file, "/values", H5T_IEEE_F32LE, {4}, {{"other.h5", 4, 0, 0, 4, 1}});
            closeHdf5(file);
        }
        const std::string whole = samples::bytesOf(path);
        const std::string elsewhere = path.string() + ": /values: is stored outside of the file";
        EXPECT_EQ(refusal(path), elsewhere);
        const std::size_t heap = whole.find(std::string("GCOL\1", 5));
        ASSERT_NE(heap, std::string::npos);
        for (std::size_t at = heap; at < heap + 128; ++at) {
            std::string changed = whole;
            changed[at] = char(~changed[at]);
            samples::writeBytes(path, changed);
            EXPECT_EQ(refusal(path), elsewhere) << "byte " << at;
        }
        std::filesystem::remove(path);
    }
}

// Text of variable length as others write it: in a dataset, and in an attribute under a header of either version.
TEST(OpeningFiles, TextOfVariableLengthIsReadAndItsDamageIsFound) {
    const samples::Folder folder("variable_text");
    const std::filesystem::path path = folder.path / "x.h5";
    const std::string longer(5000, 'y');
    for (const bool latest : {true, false}) {
        {
            const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "test");
            H5Pset_libver_bounds(access, latest ? H5F_LIBVER_LATEST : H5F_LIBVER_EARLIEST, H5F_LIBVER_LATEST);
            const Hdf5Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose, "test");
            const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "test");
            H5Tset_size(type, H5T_VARIABLE);
            const hsize_t count = 2;
            const Hdf5Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose, "test");
            const Hdf5Handle set(H5Dcreate2(file, "names", type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                                 H5Dclose, "test");
            const char* names[] = {"first", longer.c_str()};
            checkHdf5(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, names), "test");
            writeTextAttribute(file, "/", "label", longer);
        }
        {
            const Hdf5Reader in = openHdf5(path);
            EXPECT_EQ(readStrings(in, "/names"), (std::vector<std::string>{"first", longer}));
            EXPECT_EQ(readTextAttribute(in, "/", "label"), longer);
        }
        // The references to the long texts say that these are shorter: HDF5 would write all 5000 bytes regardless.
        std::string bytes = samples::bytesOf(path);
        const std::size_t heap_of_names = bytes.find(std::string("GCOL\1", 5));
        std::string length;
        append<std::uint32_t>(length, 5000);
        std::size_t shortened = 0;
        for (std::size_t at = bytes.find(length); at != std::string::npos; at = bytes.find(length, at + 1)) {
            std::uint64_t heap = 0;
            std::memcpy(&heap, bytes.data() + at + 4, 8);
            if (heap < heap_of_names || heap + 5 > bytes.size() || bytes.compare(heap, 4, "GCOL") != 0) continue;
            bytes[at] = 16, bytes[at + 1] = 0;
            ++shortened;
        }
        EXPECT_EQ(shortened, 2u);
        samples::writeBytes(path, bytes);
        EXPECT_THROW(readStrings(openHdf5(path), "/names"), InvalidInput);
        EXPECT_THROW(readTextAttribute(openHdf5(path), "/", "label"), InvalidInput);
        std::filesystem::remove(path);
    }
}

}  // namespace
}  // namespace penumbra::test_global_heaps
