#pragma once
// Answers what the main path asks about linear models of transfer (Nowrouzezahrai 2007): whether an asset has one, what
// such an asset refuses, and how it is shaded. For an asset of visibility these do nothing.
#include <string>
#include <vector>

#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading_set.h"

namespace penumbra {

// Tells whether the numbers of the asset's model are visibility. Transfer is none: nothing can be cast on it, a vertex
// has no lobe, only the CPU evaluates it, and shading does not read its numbers.
bool hasVisibility(const AssetView& asset);

// Requests of a picture or a measurement that an asset of transfer cannot serve.
struct TransferAsk {
    bool clusters = false, lobe = false, gpu = false, crowd = false;
};
// Throws BadOption for the first thing that is asked for of an asset of transfer.
void refuseForTransfer(const AssetView& asset, const TransferAsk& ask);

// Transfer has the light of all directions summed up, so that nothing but diffuse materials can be made of it. Throws
// BadOption for another way to shade an asset of transfer.
void requireDiffuse(const AssetView& asset, const ShadingChoice& shading, std::span<const std::size_t> materials);

// Shades an asset of transfer under the light that is on, without its numbers: the light is multiplied in first
// (TransferEvaluator). Negative values are 0. Sizes `radiance`. Returns false for an asset of visibility.
bool shadeTransfer(Evaluator& evaluator, const ShadingSet& shading, int threads, std::vector<Vec3>& radiance);

// Returns how many bands the truth of an asset needs. Throws InvalidInput where the truth is transfer, and the model
// visibility.
int bandsOfTruth(const AssetView& asset, const AssetView& truth);

// Returns how many bands E_transfer compares: those of an asset of transfer, else up to 6, one fewer than the truth
// has. Less than 1 where the truth has too few of them.
int transferErrorOrder(const AssetView& asset, const AssetView& truth);

// Describes a model of transfer, a line each. Empty for one of visibility.
std::vector<std::string> linesOfTransfer(const AssetView& asset);

}  // namespace penumbra
