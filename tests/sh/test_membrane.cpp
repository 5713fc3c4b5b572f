// Tests the text of a membrane and what is refused of it.
#include <gtest/gtest.h>

#include <stdexcept>

#include "sh/brdf/membrane.h"

namespace penumbra::test_membrane {
namespace {

TEST(Membrane, TextIsReadBack) {
    for (const char* text : {"membrane:rho=0.5/0.25/0,tau=0.3/0.3/1", "membrane:rho=0.1/0.1/0.1,tau=0/0/0,back=open"})
        EXPECT_EQ(toString(*parseMembrane(text)), text);
    EXPECT_EQ(*parseMembrane("membrane"), Membrane());
    EXPECT_EQ(parseMembrane("membrane:rho=0.7,tau=0.3")->rho, (Vec3{0.7f, 0.7f, 0.7f})) << "0.7f + 0.3f is above 1";
    EXPECT_FALSE(parseMembrane("lambert"));
    EXPECT_FALSE(parseMembrane("membranes:rho=1"));
}

TEST(Membrane, WrongValuesAreNamed) {
    for (const auto& [text, words] : {std::pair("membrane:rho=0.8,tau=0.3", "rho + tau must be from 0 to 1"),
                                      {"membrane:rho=0.5/0.5/0.8,tau=0/0/0.3", "rho + tau must be from 0 to 1"},
                                      {"membrane:rho=-0.1", "membrane rho must be a number from 0 to 1"},
                                      {"membrane:tau=nan", "membrane tau must be a number from 0 to 1"},
                                      {"membrane:tau=1e5", "membrane tau must be a number from 0 to 1"},
                                      {"membrane:tau=0.1/0.2", "membrane tau must be three numbers"},
                                      {"membrane:back=black", "back must be own or open"},
                                      {"membrane:color=1", "use rho, tau, back"}}) {
        try {
            parseMembrane(text);
            FAIL() << text;
        } catch (const std::invalid_argument& error) {
            EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
        }
    }
}

}  // namespace
}  // namespace penumbra::test_membrane
