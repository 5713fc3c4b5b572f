// Joins the chains of FBX nodes. assimp splits an FBX node into a chain, NAME_$AssimpFbx$_Translation,
// ..._PreRotation, ..., NAME, and each file has only some of its links. Here each chain becomes one node again. Then
// a clip fits the rig of another file, and a joint has its whole rotation.
#include <algorithm>
#include <utility>

#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

bool isLinkOf(const Node& link, const Node& node) { return link.name.rfind(node.name + "_$AssimpFbx$_", 0) == 0; }

// Returns for each node its links from the top down, with itself last. The list of a link is empty.
std::vector<std::vector<int>> findChains(const std::vector<Node>& nodes) {
    std::vector<int> children(nodes.size());
    for (const Node& node : nodes)
        if (node.parent >= 0) ++children[std::size_t(node.parent)];
    std::vector<std::vector<int>> chains(nodes.size());
    std::vector<bool> is_link(nodes.size());
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        chains[n] = {int(n)};
        for (int up = nodes[n].parent;
             up >= 0 && isLinkOf(nodes[std::size_t(up)], nodes[n]) && children[std::size_t(up)] == 1;
             up = nodes[std::size_t(up)].parent) {
            chains[n].insert(chains[n].begin(), up);
            is_link[std::size_t(up)] = true;
        }
    }
    for (std::size_t n = 0; n < nodes.size(); ++n)
        if (is_link[n]) chains[n].clear();
    return chains;
}

void setDecomposed(const Matrix& m, Node& node) {
    const Decomposition parts = decompose(m);
    node.translation = parts.translation;
    node.rotation = parts.rotation;
    node.scale = parts.scale;
    node.matrix.reset();
}

Matrix productOf(const std::vector<Matrix>& locals, const std::vector<int>& chain) {
    Matrix m = kIdentityMatrix;
    for (const int link : chain) m = multiply(m, locals[std::size_t(link)]);
    return m;
}

// Multiplies a chain at each key time of any of its links, and stores translation, rotation and scale of one node.
// The result is linear between keys, as the links are; a rotation about a pivot then moves on the chord between two
// keys.
void bakeChain(const std::vector<Node>& nodes, const Clip& clip, const std::vector<int>& chain, int new_node,
               std::vector<Channel>& out) {
    std::vector<double> times;
    for (const Channel& channel : clip.channels)
        if (std::find(chain.begin(), chain.end(), channel.node) != chain.end())
            times.insert(times.end(), channel.times.begin(), channel.times.end());
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    if (times.empty()) return;
    std::array<Channel, 3> channels;
    const std::array paths{Channel::Path::kTranslation, Channel::Path::kRotation, Channel::Path::kScale};
    for (std::size_t i = 0; i < 3; ++i) {
        channels[i].node = new_node;
        channels[i].path = paths[i];
        channels[i].times = times;
    }
    for (const double time : times) {
        const Decomposition parts = decompose(productOf(localTransforms(nodes, &clip, time), chain));
        channels[0].values.insert(channels[0].values.end(), parts.translation.begin(), parts.translation.end());
        channels[1].values.insert(channels[1].values.end(), parts.rotation.begin(), parts.rotation.end());
        channels[2].values.insert(channels[2].values.end(), parts.scale.begin(), parts.scale.end());
    }
    out.insert(out.end(), channels.begin(), channels.end());
}

// Makes one node of each chain. The result maps old nodes to new ones, and links to -1.
std::vector<int> mergeNodes(const std::vector<Node>& old_nodes, const std::vector<std::vector<int>>& chains,
                            std::vector<Node>& nodes) {
    const std::vector<Matrix> rest = localTransforms(old_nodes, nullptr, 0);
    std::vector<int> new_of_old(old_nodes.size(), -1);
    for (std::size_t n = 0; n < old_nodes.size(); ++n) {
        if (chains[n].empty()) continue;
        Node node = old_nodes[n];
        const int parent = old_nodes[std::size_t(chains[n].front())].parent;
        node.parent = parent < 0 ? -1 : new_of_old[std::size_t(parent)];
        if (chains[n].size() > 1) setDecomposed(productOf(rest, chains[n]), node);
        new_of_old[n] = int(nodes.size());
        nodes.push_back(std::move(node));
    }
    return new_of_old;
}

}  // namespace

void collapseFbxPivots(RigSource& source) {
    const std::vector<std::vector<int>> chains = findChains(source.nodes);
    const std::vector<Node> old_nodes = std::exchange(source.nodes, {});
    const std::vector<int> new_of_old = mergeNodes(old_nodes, chains, source.nodes);
    for (SourceSkin& skin : source.skins)
        for (int& node : skin.nodes) node = new_of_old[std::size_t(node)];
    for (SourcePart& part : source.parts) part.node = new_of_old[std::size_t(part.node)];
    for (Clip& clip : source.clips) {
        std::vector<Channel> channels;
        std::vector<bool> whole(old_nodes.size());
        for (const Channel& channel : clip.channels) {
            const std::size_t n = std::size_t(channel.node);
            if (new_of_old[n] < 0) continue;
            whole[n] = true;
            channels.push_back(channel);
            channels.back().node = new_of_old[n];
        }
        for (std::size_t n = 0; n < chains.size(); ++n)
            if (!whole[n] && chains[n].size() > 1) bakeChain(old_nodes, clip, chains[n], new_of_old[n], channels);
        clip.channels = std::move(channels);
    }
}

}  // namespace penumbra
