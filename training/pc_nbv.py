"""Trains PC-NBV on a data set of `nextview dataset pc-nbv`. docs/methods/pc-nbv.md has the commands.

The network has the parts of the published one (Zeng et al. 2020), and smaller ones.
"""

import numpy
import torch
from torch import nn
from torch.nn.functional import relu

from recipe import Recipe, Samples, run

N_VIEWS = 33
N_NEIGHBORS = 16
FEATURES, GROWTH, LIFTED, HIDDEN = 24, 12, 256, 128

# The first view on each of the four rings of eight.
RINGS = range(1, N_VIEWS, 8)


class PcNbvNetwork(nn.Module):
    def __init__(self):
        super().__init__()
        edge = FEATURES + 3 * GROWTH
        joined = 2 * (2 * edge + FEATURES) + N_VIEWS
        self.points = nn.Linear(3, FEATURES)
        for block in (1, 2):
            for i, n_in in enumerate([2 * FEATURES, FEATURES + GROWTH, FEATURES + 2 * GROWTH], 1):
                setattr(self, f"edge{block}_{i}", nn.Linear(n_in, GROWTH))
        self.between = nn.Linear(edge + FEATURES, FEATURES)
        self.query = nn.Linear(joined, joined // 4)
        self.key = nn.Linear(joined, joined // 4)
        self.value = nn.Linear(joined, joined)
        self.lift1 = nn.Linear(joined, LIFTED)
        self.lift2 = nn.Linear(LIFTED, LIFTED)
        self.fc1 = nn.Linear(LIFTED, LIFTED)
        self.fc2 = nn.Linear(LIFTED, HIDDEN)
        self.fc3 = nn.Linear(HIDDEN, N_VIEWS)
        # Attention changes nothing at first, as where the published network multiplies it by a number that is 0 at first.
        nn.init.zeros_(self.value.weight)
        nn.init.zeros_(self.value.bias)

    def edge_block(self, x, block):
        n_batch, n_points, n_features = x.shape
        with torch.no_grad():
            distances = torch.cdist(x, x, compute_mode="donot_use_mm_for_euclid_dist")
            distances.diagonal(dim1=1, dim2=2).fill_(float("inf"))
            nearest = distances.topk(N_NEIGHBORS, largest=False).indices
            nearest = (nearest + n_points * torch.arange(n_batch)[:, None, None]).flatten()
        others = x.flatten(0, 1).index_select(0, nearest).view(n_batch, n_points, N_NEIGHBORS, n_features)
        own = x.unsqueeze(2).expand_as(others)
        layers = [getattr(self, f"edge{block}_{i}") for i in (1, 2, 3)]
        y = torch.cat([relu(layers[0](torch.cat([own, others - own], 3))), own], 3)
        y = torch.cat([relu(layers[1](y)), y], 3)
        return torch.cat([layers[2](y), y], 3).amax(2)

    def forward(self, points, visited):
        before = self.points(points)
        first = torch.cat([self.edge_block(before, 1), before], 2)
        second = torch.cat([self.edge_block(relu(self.between(first)), 2), first], 2)
        shared = torch.cat([second.amax(1), visited], 1)
        x = torch.cat([second, shared.unsqueeze(1).expand(-1, second.shape[1], -1)], 2)
        weights = (self.query(x) @ self.key(x).transpose(1, 2)).softmax(2)
        x = x + weights @ self.value(x)
        x = self.lift2(relu(self.lift1(x))).amax(1)
        return self.fc3(relu(self.fc2(relu(self.fc1(x)))))


class CloudSamples(Samples):
    def __init__(self, files, digits=range(10)):
        super().__init__(files, digits)
        self.points = torch.from_numpy(self.field("points"))
        self.visited = torch.from_numpy(self.field("visited")).float()
        surface = torch.from_numpy(self.field("surface").astype("float32"))
        self.targets = self.gains / surface[:, None]


def symmetry(n_quarters, is_mirrored):
    """A symmetry of the views and of the cube that keeps the vertical: which view comes in the place of each, and what points are
    multiplied by."""
    views = torch.arange(N_VIEWS)
    cos, sin = [(1, 0), (0, 1), (-1, 0), (0, -1)][n_quarters]
    matrix = torch.tensor([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]], dtype=torch.float32)
    if is_mirrored:
        matrix = matrix @ torch.diag(torch.tensor([1.0, -1.0, 1.0]))
    for ring in RINGS:
        for step in range(8):
            to = (-step if is_mirrored else step) + 2 * n_quarters
            views[ring + to % 8] = ring + step
    return views, matrix.T


class PcNbv(Recipe):
    network, title = "pc-nbv", "PC-NBV, after Zeng et al. 2020"
    Samples = CloudSamples
    measures, decisive = ("error", "top1", "gain"), 2

    def model(self, args):
        return PcNbvNetwork()

    def loss(self, model, samples, part):
        views, matrix = symmetry(torch.randint(4, ()).item(), torch.randint(2, ()).item())
        found = model(samples.points[part] @ matrix, samples.visited[part][:, views])
        return ((found - samples.targets[part][:, views]) ** 2).sum(1).mean() / 2

    def outputs(self, model, samples):
        parts = zip(samples.points.split(32), samples.visited.split(32))
        return torch.cat([model(*part) for part in parts])

    def judge(self, outputs, samples):
        error = ((outputs - samples.targets) ** 2).mean().sqrt().item()
        return error, *self.score(self.views(outputs, samples), samples)

    def views(self, outputs, samples):
        return outputs.argmax(1)

    def inputs(self, samples):
        visited, points = samples.visited.byte().numpy(), samples.points.flatten(1).numpy()
        return numpy.concatenate([visited, points.view("u1")], 1)


if __name__ == "__main__":
    run(PcNbv().commands(__doc__, epochs=2, batch=32, step=2e-3)[0])
