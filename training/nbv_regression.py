"""Trains NBV regression on a data set of `nextview dataset nbv-regression`. docs/methods/nbv-regression.md has the commands.

The network names the direction of the best view (Vasquez-Gomez et al. 2021). The architecture is ours: the convolutions of NBV-Net with
the weights of the library, which stay as they are, and smaller layers after them.
"""

import math
from pathlib import Path

import torch
from safetensors.torch import load_file
from torch.nn.functional import normalize

from grid_network import GridNetwork, GridSamples
from recipe import Recipe, run

N_VIEWS = 128
UNITS = [500, 100, 3]

# The library's weights of NBV-Net.
NBV_NET = Path(__file__).parent / "../crates/nextview-learned/weights/nbv_net.safetensors"

# In each batch, grids are mirrored and turned by one of the 48 symmetries of the cube: an order of the axes, and which are reversed.
AXES = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]]


def fibonacci_sphere():
    """The directions of the views of a sample, in their order."""
    k = torch.arange(N_VIEWS, dtype=torch.float64)
    z = 1 - (2 * k + 1) / N_VIEWS
    azimuth = k * math.pi * (3 - math.sqrt(5))
    radius = (1 - z * z).sqrt()
    return torch.stack([radius * azimuth.cos(), radius * azimuth.sin(), z], 1).float()


class NbvRegression(Recipe):
    network, title = "nbv-regression", "NBV regression, after Vasquez-Gomez et al. 2021"
    Samples = GridSamples
    measures, decisive = ("loss", "top1", "gain"), 2

    def __init__(self):
        self.directions = fibonacci_sphere()

    def model(self, args):
        model = GridNetwork(UNITS, 0.0)
        convolutions = {name: value.float() for name, value in load_file(NBV_NET).items() if name.startswith("conv")}
        model.load_state_dict(convolutions, strict=False)
        for name, parameter in model.named_parameters():
            parameter.requires_grad = not name.startswith("conv")
        return model

    def loss(self, model, samples, part):
        grids, targets = samples.grids[part], self.directions[samples.labels[part]]
        axes = AXES[torch.randint(len(AXES), ()).item()]
        reversed_axes = [axis for axis in range(3) if torch.randint(2, ()).item()]
        grids = grids.permute(0, *(axis + 1 for axis in axes)).flip([axis + 1 for axis in reversed_axes])
        targets = targets[:, axes]
        targets[:, reversed_axes] *= -1
        return self.distance(model(grids), targets)

    def distance(self, outputs, targets):
        """Mean of 1 - the cosine of the angle between outputs and targets."""
        return (1 - (normalize(outputs) * targets).sum(1)).mean()

    def outputs(self, model, samples):
        return torch.cat([model(part) for part in samples.grids.split(256)])

    def judge(self, outputs, samples):
        loss = self.distance(outputs, self.directions[samples.labels]).item()
        return loss, *self.score(self.views(outputs, samples), samples)

    def views(self, outputs, samples):
        return (outputs @ self.directions.T).argmax(1)

    def inputs(self, samples):
        return samples.grids.flatten(1).numpy()


if __name__ == "__main__":
    run(NbvRegression().commands(__doc__, epochs=5, batch=64, step=1e-3)[0])
