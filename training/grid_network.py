"""The networks that take a grid: NBV-Net and NBV regression, which differ in the fully connected layers."""

import torch
from torch import nn
from torch.nn.functional import dropout, max_pool3d, relu

from recipe import Samples

CHANNELS = [1, 10, 12, 8]
N_FEATURES = 512

# The byte of a grid that stands for probability 1.
MAX_BYTE = 254


class GridNetwork(nn.Module):
    def __init__(self, units, drop):
        super().__init__()
        self.drop = drop
        for i, (n_in, n_out) in enumerate(zip(CHANNELS, CHANNELS[1:]), 1):
            setattr(self, f"conv{i}", nn.Conv3d(n_in, n_out, 3, padding=1))
        units = [N_FEATURES, *units]
        self.n_dense = len(units) - 1
        for i, (n_in, n_out) in enumerate(zip(units, units[1:]), 1):
            setattr(self, f"fc{i}", nn.Linear(n_in, n_out))
        for layer in self.children():
            # He et al. 2015. PyTorch's own choice is so small that eight layers learn next to nothing for many epochs.
            nn.init.kaiming_normal_(layer.weight, nonlinearity="relu")
            nn.init.zeros_(layer.bias)
        # With the channels of a cell beside each other, convolutions take half the time.
        self.to(memory_format=torch.channels_last_3d)

    def features(self, grids):
        """What the convolutions make of grids, which are bytes."""
        x = grids.unsqueeze(1).float() / MAX_BYTE
        for i in range(1, len(CHANNELS)):
            x = max_pool3d(relu(getattr(self, f"conv{i}")(x)), 2)
        return x.flatten(1)

    def forward(self, grids):
        """The values of the last layer."""
        x = self.features(grids)
        for i in range(1, self.n_dense):
            x = dropout(relu(getattr(self, f"fc{i}")(x)), self.drop, self.training)
        return getattr(self, f"fc{self.n_dense}")(x)


class GridSamples(Samples):
    def __init__(self, files, digits=range(10)):
        super().__init__(files, digits)
        self.grids = torch.from_numpy(self.field("grid"))
